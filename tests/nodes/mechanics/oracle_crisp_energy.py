"""CRISP robots as the least energy of rods cut into straight-sided elements.

Nothing of Cosserat's equations: each rod is a chain of elements of constant curvature, its elastic
energy less the work of forces is made stationary while the grasps hold, with Lagrange's multipliers
and Newton's method (derivatives by complex steps). Errors fall with the square of the elements'
length, so Richardson's extrapolation is exact to a few further orders. The smallest eigenvalue of
the energy's second variation among motions that the grasps allow, against that of the unloaded
rods, is the margin of stability: positive is stable.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import eigh, lu_factor, lu_solve, null_space

from tests.nodes.mechanics.oracle_crisp_rods import Robot, cross, dot

COMPLEX_STEP = 1e-30


@dataclass(frozen=True)
class Chain:
    """A rod in elements: their lengths, and at which node each place of interest lies."""

    lengths: np.ndarray
    nodes: dict[float, int]


@dataclass(frozen=True)
class Placed:
    """Nodes of a chain in the world, in columns: places (n+1, 3, k), frames (n+1, 3, 3, k)."""

    places: np.ndarray
    frames: np.ndarray
    middles: np.ndarray  # (n, 3, k) tangents in the middles of the elements


@dataclass(frozen=True)
class LeastEnergy:
    """A stationary point of the energy under the grasps."""

    tip_point: np.ndarray
    tip_frame: np.ndarray
    elastic_energy: float
    margin: float
    unknowns: np.ndarray
    chains: tuple[Chain, ...]


def cut(robot: Robot, elements: int, level: int) -> tuple[Chain, ...]:
    """Cut each rod into about so many elements, halved `level` times, with nodes at all joints and
    loads."""
    chains = []
    for rod, length in enumerate(robot.lengths):
        marks = [joint.arc for joint in robot.joints] + [load[0] for load in robot.loads]
        stops = sorted({0.0, length, *(marks if rod == 0 else [])})
        sides: list[float] = []
        nodes = {0.0: 0}
        for begin, end in pairwise(stops):
            count = int(np.ceil(elements * (end - begin) / length)) * 2**level
            sides += [(end - begin) / count] * count
            nodes[end] = len(sides)
        chains.append(Chain(np.array(sides), nodes))
    return tuple(chains)


def hat(vector):
    """Return (n, 3, 3, k) matrices that take the vector product with (n, 3, k) vectors."""
    x, y, z = np.moveaxis(vector, 1, 0)
    nothing = np.zeros_like(x)
    rows = [[nothing, -z, y], [z, nothing, -x], [-y, x, nothing]]
    return np.moveaxis(np.array(rows), (0, 1), (1, 2))


def turns(vector):
    """Return rotations by small vectors (n, 3, k), and their left Jacobians, by power series."""
    squared = (vector * vector).sum(1)[:, None, None]
    skew = hat(vector)
    skew2 = np.einsum("nijk,njlk->nilk", skew, skew)
    series = [np.zeros_like(squared)] * 3
    term = np.ones_like(squared)  # (-w.w)^m / (2 m)!
    for m in range(10):
        ones = [1 / (2 * m + 1), 1 / ((2 * m + 1) * (2 * m + 2))]
        series[0] = series[0] + term * ones[0]
        series[1] = series[1] + term * ones[1]
        series[2] = series[2] + term * ones[1] / (2 * m + 3)
        term = -term * squared * ones[1]
    same = np.eye(3)[None, :, :, None]
    return same + series[0] * skew + series[1] * skew2, same + series[1] * skew + series[2] * skew2


def place(chain: Chain, entry, frame, curvature) -> Placed:
    """Lay a chain from its entry; curvature (n, 3, k) about the body's axes in each element."""
    sides = chain.lengths[:, None, None]
    whole, half = turns(sides * curvature)[0], turns(sides / 2 * curvature)[0]
    columns = curvature.shape[2]
    frames = np.empty((len(sides) + 1, 3, 3, columns), complex)
    frames[0] = frame[:, :, None]
    for n in range(len(sides)):
        frames[n + 1] = np.einsum("ijk,jlk->ilk", frames[n], whole[n])
    middles = np.einsum("nijk,njk->nik", frames[:-1], half[:, :, 2])
    steps = np.concatenate([np.broadcast_to(entry[:, None], (1, 3, columns)), sides * middles])
    return Placed(np.cumsum(steps, 0), frames, middles)


def gradient(chain: Chain, placed: Placed, curvature, pushes):
    """Return (n, 3, k) derivatives by curvature of work done at nodes.

    Parameters
    ----------
    pushes : of (node, force (3, k), moment (3, k)): the work is force . dp + moment . dphi.
    """
    count, columns = len(chain.lengths), curvature.shape[2]
    force = np.zeros((count + 2, 3, columns), complex)
    moment = np.zeros_like(force)
    for node, push, twist in pushes:
        force[node] += push
        moment[node] += twist + cross(placed.places[node], push)
    force = np.cumsum(force[::-1], 0)[::-1][1:-1]
    moment = np.cumsum(moment[::-1], 0)[::-1][1:-1]
    sides = chain.lengths[:, None, None]
    swap = (1, 0, 2)
    arm = cross(placed.places[1:].transpose(swap), force.transpose(swap)).transpose(swap)
    shift = cross(placed.middles.transpose(swap), force.transpose(swap)).transpose(swap) * sides
    whole, half = turns(sides * curvature)[1], turns(sides / 2 * curvature)[1]
    back = np.einsum("nijk,nik->njk", placed.frames[:-1], moment - arm)
    back_half = np.einsum("nijk,nik->njk", placed.frames[:-1], shift)
    return sides * (
        np.einsum("nijk,nik->njk", whole, back) + np.einsum("nijk,nik->njk", half, back_half) / 2
    )


def _pairs(joint):
    """Return which columns of tool and snare meet at which cosine, and with which sign."""
    if not joint.rigid:
        return [(2, 2, 1.0, joint.cosine)]
    return [(0, 2, 1.0, 0.0), (1, 1, 1.0, 0.0), (2, 0, 1.0, 0.0)]  # x.z, y.y, z.x of the two


class Stationary:
    """The equations of a stationary energy of one robot, in elements."""

    def __init__(self, robot: Robot, chains: tuple[Chain, ...], detour: float = 0.0) -> None:
        self.robot, self.chains = robot, chains
        self.sizes = [3 * len(chain.lengths) for chain in chains]
        rest = [np.tile(u, len(c.lengths)) for u, c in zip(robot.precurvature, chains, strict=True)]
        self.rest = np.concatenate(rest)
        sides = [np.tile([np.cos(n), np.sin(n), 0], k // 3) for n, k in enumerate(self.sizes)]
        self.detour = detour * np.concatenate(sides)
        pairs = zip(robot.stiffness, chains, strict=True)
        self.metric = np.concatenate([np.outer(c.lengths, k).ravel() for k, c in pairs])

    def placed(self, unknowns):
        """Return each rod's curvature and its nodes in the world."""
        curvatures, begin = [], 0
        for size in self.sizes:
            curvatures.append(unknowns[begin : begin + size].reshape(size // 3, 3, -1))
            begin += size
        fixed = zip(self.chains, self.robot.entry, self.robot.frames, curvatures, strict=True)
        return curvatures, [place(*rod) for rod in fixed]

    def __call__(self, unknowns, share, offsets):
        """Return gradient and gaps of the grasps in columns, with `share` of the loads, and the
        gaps still open by `offsets`."""
        curvatures, placed = self.placed(unknowns)
        tool, nodes = placed[0], self.chains[0].nodes
        multipliers = list(unknowns[self.rest.size :])
        pushes: list[list] = [[] for _ in self.chains]
        gaps = []
        for arc, force, _ in self.robot.loads:
            pushes[0].append((nodes[arc], -share * force[:, None], 0.0))
        for joint in self.robot.joints:
            here, there = nodes[joint.arc], len(self.chains[joint.snare].lengths)
            snare = placed[joint.snare]
            gaps.append(tool.places[here] - snare.places[there])
            force = np.array([multipliers.pop(0) for _ in range(3)])
            moment = 0.0
            for mine, its, sign, cosine in _pairs(joint):
                a, b = tool.frames[here][:, mine], sign * snare.frames[there][:, its]
                gaps.append((dot(a, b) - cosine)[None])
                moment = moment + multipliers.pop(0) * cross(a, b)
            pushes[0].append((here, force, moment))
            pushes[joint.snare].append((there, -force, -moment))
        rest = self.rest + (1 - share) * self.detour
        bent = self.metric[:, None] * (unknowns[: self.rest.size] - rest[:, None])
        rods = zip(self.chains, placed, curvatures, pushes, strict=True)
        pulled = [gradient(*rod).reshape(-1, unknowns.shape[1]) for rod in rods]
        closed = np.concatenate(gaps) if gaps else np.empty((0, unknowns.shape[1]))
        return np.concatenate([bent + np.concatenate(pulled), closed - offsets[:, None]])

    def count(self):
        """Return how many numbers the grasps fix."""
        return sum(3 + len(_pairs(joint)) for joint in self.robot.joints)

    def linearise(self, unknowns, share, offsets):
        """Return the equations' values and their Jacobian."""
        columns = unknowns[:, None] + 1j * COMPLEX_STEP * np.eye(len(unknowns))
        values = self(columns, share, offsets)
        return values[:, 0].real, values.imag / COMPLEX_STEP

    def newton(self, unknowns, share, offsets, steps=30):
        """Return the stationary point that Newton's method ends in, None if in none."""
        for _ in range(steps):
            values, slope = self.linearise(unknowns, share, offsets)
            if not np.isfinite(slope).all():
                return None
            size = 1.0 / np.sqrt(np.concatenate([self.metric, np.full(self.count(), 1.0)]))
            move = size * lu_solve(lu_factor(size[:, None] * slope * size), size * values)
            unknowns = unknowns - move
            if np.abs(move[: self.rest.size]).max() < 1e-13:
                return unknowns
        return None


def assemble(
    robot: Robot, elements: int = 10, steps: int = 10, detour: float = 0.0
) -> np.ndarray | None:
    """Return curvatures and multipliers of a coarse robot whose grasps are drawn together bit by
    bit, while its loads grow; with a detour, 1/mm, on which rods are first bent and then less,
    past straight rods that would have to buckle."""
    system = Stationary(robot, cut(robot, elements, 0), detour)
    unknowns = np.concatenate([system.rest + system.detour, np.zeros(system.count())])
    nothing = np.zeros(system.count())
    apart = system(unknowns[:, None].astype(complex), 0.0, nothing)[system.rest.size :, 0].real
    for share in np.arange(1, steps + 1) / steps:
        found = system.newton(unknowns, share, (1 - share) * apart)
        if found is None:
            return None
        unknowns = found
    return unknowns


def refine(robot: Robot, coarse: np.ndarray, elements: int, level: int) -> LeastEnergy | None:
    """Return the stationary point beside a coarse one with elements halved `level` times."""
    assert all(not np.any(load[2]) for load in robot.loads), "a fixed moment has no potential"
    system = Stationary(robot, cut(robot, elements, level))
    count = system.count()
    finer = np.repeat(coarse[: len(coarse) - count].reshape(-1, 3), 2**level, 0).ravel()
    start = np.concatenate([finer, coarse[len(coarse) - count :]])
    unknowns = system.newton(start, 1.0, np.zeros(count))
    if unknowns is None:
        return None
    tool = system.placed(unknowns[:, None].astype(complex))[1][0]
    strain = unknowns[: system.rest.size] - system.rest
    return LeastEnergy(
        tool.places[-1, :, 0].real,
        tool.frames[-1, :, :, 0].real,
        float(system.metric @ strain**2 / 2),
        margin(system, unknowns),
        unknowns,
        system.chains,
    )


def margin(system: Stationary, unknowns: np.ndarray) -> float:
    """Return the least eigenvalue of the second variation on motions that the grasps allow."""
    free = system.rest.size
    slope = system.linearise(unknowns, 1.0, np.zeros(system.count()))[1]
    allowed = null_space(slope[free:, :free]) if system.count() else np.eye(free)
    second = allowed.T @ slope[:free, :free] @ allowed
    unloaded = allowed.T @ (system.metric[:, None] * allowed)
    least = eigh((second + second.T) / 2, unloaded, eigvals_only=True, subset_by_index=[0, 0])
    return float(least[0])


def extrapolate(coarse, middle, fine):
    """Return Richardson's limit of three values with elements halved twice (orders 2 and 4)."""
    once, twice = (4 * middle - coarse) / 3, (4 * fine - middle) / 3
    return (16 * twice - once) / 15
