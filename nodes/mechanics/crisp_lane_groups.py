"""Edges of CRISP robots laid out for the kernel that takes sixteen at once, and its results."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nodes.errors import BadInput
from nodes.mechanics.crisp_arrays import to_grasps, to_rods
from nodes.mechanics.crisp_reach import find_grasps
from nodes.mechanics.parameters import FollowCrispEdgesParameters
from nodes.mechanics.robots import CrispSetup

if TYPE_CHECKING:
    from nodes.kernels.crisp_straight_edges import Edges
    from nodes.kernels.crisp_straight_newton import Solver
    from nodes.kernels.crisp_straight_residual import Pose, Robot, Workspace


class Problem(NamedTuple):
    """A setup in units in which lengths and stiffness are near 1: gaps, angles and moments then
    weigh alike. unit_mm : length that is 1; wrench_unit : (6,) N mm and N that are 1."""

    setup: CrispSetup
    robot: "Robot"
    unit_mm: float
    wrench_unit: np.ndarray

    def to_poses(self, tips: np.ndarray) -> np.ndarray:
        """Return patient_from_camera (..., 4, 4), mm, of tips (..., 9)."""
        poses = np.zeros((*tips.shape[:-1], 4, 4))
        z, x = tips[..., 3:6], tips[..., 6:]
        poses[..., :3, 0], poses[..., :3, 2] = x, z
        for axis in range(3):  # NumPy's cross product takes ten times as long
            first, second = (axis + 1) % 3, (axis + 2) % 3
            poses[..., axis, 1] = z[..., first] * x[..., second] - z[..., second] * x[..., first]
        poses[..., :3, 3] = tips[..., :3] * self.unit_mm + self.setup.entry_points_patient_mm[0]
        poses[..., 3, 3] = 1.0
        return poses

    def to_wrenches(self, wrenches: np.ndarray) -> np.ndarray:
        """Return moments, N mm, and forces, N, at all needles' entry points (..., needle, 6), of
        those of the joints' snares (..., joint, 6); the tool's balances the others."""
        entries = self.setup.entry_points_patient_mm
        full = np.full((*wrenches.shape[:-2], len(entries), 6), np.nan)
        full[..., self.robot.snare, :] = wrenches * self.wrench_unit
        moments, forces = full[..., 1:, :3], full[..., 1:, 3:]
        arms = np.cross((entries[1:] - entries[0])[:, None], np.eye(3)).reshape(-1, 3)
        about = moments.sum(-2) + forces.reshape(*forces.shape[:-2], -1) @ arms
        full[..., 0, :] = -np.concatenate([about, forces.sum(-2)], axis=-1)
        return full


class Motion(NamedTuple):
    """Edges, wrenches in the problem's units.

    frames : (edge, needle, 3, 3) at the start; turns : (edge, needle, 3) rotation vectors of the
    whole edge; lengths, growths : (edge, needle) mm; wrenches : (edge, joint, 6); counts : (edge,).
    """

    frames: np.ndarray
    turns: np.ndarray
    lengths: np.ndarray
    growths: np.ndarray
    wrenches: np.ndarray
    counts: np.ndarray

    def cut(self, chosen: np.ndarray, first: np.ndarray, wrenches: np.ndarray):
        """Return the rests of chosen edges from their steps `first`, with the wrenches there."""
        from scipy.spatial.transform import Rotation

        share = (first / np.maximum(self.counts[chosen], 1))[:, None]
        turned = (share[..., None] * self.turns[chosen]).reshape(-1, 3)
        frames = self.frames[chosen]
        rotations = Rotation.from_rotvec(turned).as_matrix().reshape(frames.shape)
        return Motion(
            rotations @ frames,
            (1 - share[..., None]) * self.turns[chosen],
            self.lengths[chosen] + share * self.growths[chosen],
            (1 - share) * self.growths[chosen],
            wrenches,
            self.counts[chosen] - first,
        )

    def first_step(self, finer: int):
        """Return the first step of each edge, cut into finer ones."""
        share = 1 / self.counts[:, None]
        return self._replace(
            turns=share[..., None] * self.turns,
            growths=share * self.growths,
            counts=np.full(len(self.counts), finer),
        )

    def hold(self, count: int = 0):
        """Return edges of so many steps that stay at the starts."""
        return self._replace(
            turns=np.zeros_like(self.turns),
            growths=np.zeros_like(self.growths),
            counts=np.full(len(self.counts), count),
        )


class Found(NamedTuple):
    """Results in the problem's units: wrenches (edge, step, joint, 6), tips (edge, step, 9) seen
    from the tool's entry point, totals (edge, step) of the residual's magnitude."""

    wrenches: np.ndarray
    tips: np.ndarray
    totals: np.ndarray

    def take(self, edge, every):
        """Return each `every`-th step of an edge after its start; of 0, the start alone."""
        first = slice(1) if every == 0 else slice(every, None, every)
        return Found(*(values[edge, first] for values in self))

    def put(self, edge, step, more) -> None:
        """Write results of the steps after one."""
        for values, new in zip(self, more, strict=True):
            room = values[edge, step + 1 :]
            room[: len(new)] = new[: len(room)]


def pose_problem(setup: CrispSetup, lengths_mm: np.ndarray) -> Problem:
    """Return a setup as the kernel takes it.

    Raises
    ------
    BadInput : if a needle is curved when nothing bends it.
    """
    from nodes.kernels.crisp_straight_residual import Robot

    rods = to_rods(setup)
    if np.any(rods.precurvature):
        raise BadInput(
            f"pre-curvature {rods.precurvature.tolist()} /mm",
            "edges are followed with needles that are straight when nothing bends them",
            "use straight needles, or solve each configuration by itself",
        )
    unit, bending = float(np.mean(lengths_mm)), float(rods.bending[0])
    grasps = to_grasps(setup, float(lengths_mm.flat[0]))
    robot = Robot(
        rods.bending / bending, rods.torsion / bending, rods.entry / unit,
        grasps.snare, grasps.rigid, grasps.cosine,
    )  # fmt: skip
    wrench_unit = bending / unit ** np.array([1.0, 1, 1, 2, 2, 2])
    return Problem(setup, robot, unit, wrench_unit)


def follow_lanes(
    problem: Problem,
    motion: Motion,
    parameters: FollowCrispEdgesParameters,
    is_exact: bool,
    from_rest: bool = False,
) -> Found:
    """Return what the kernel finds along edges; nan where it gave up before.

    Parameters
    ----------
    is_exact : whether each iteration has a Jacobian of its own.
    from_rest : whether edges close the gaps that their wrenches leave at the start.
    """
    order = np.argsort(motion.counts, kind="stable")  # so that lanes of one group end together
    place = np.argsort(order)
    sorted_motion = Motion(*(values[order] for values in motion))
    found, signs = _run_kernel(problem, sorted_motion, parameters, is_exact, from_rest)
    found, signs = Found(*(values[place] for values in found)), signs[place]
    if from_rest:
        return found
    tolerance = parameters.tolerance_mm / problem.unit_mm
    if found.totals.shape[1] > 2:  # the second step shows whether the first one jumped
        found.totals[(motion.counts > 1) & ~(found.totals[:, 2] < tolerance), 1] = np.inf
    last = count_true(found.totals < tolerance) - 1
    stopped = np.flatnonzero((last > 0) & (last < motion.counts))
    if len(stopped):
        there = motion.cut(stopped, last[stopped], found.wrenches[stopped, last[stopped]]).hold()
        signs[stopped, 1] = _run_kernel(problem, there, parameters, True, False)[1][:, 0]
    found.totals[(last > 0) & (signs[:, 0] != signs[:, 1]), 1:] = np.inf  # a fold lies between
    return found


def _run_kernel(
    problem: Problem,
    motion: Motion,
    parameters: FollowCrispEdgesParameters,
    is_exact: bool,
    from_rest: bool,
) -> tuple[Found, np.ndarray]:
    """Return what is found, and signs (edge, 2) of the Jacobian's determinant at both ends."""
    from nodes.kernels.crisp_lanes import make_lanes
    from nodes.kernels.crisp_straight_edges import Rules, Track, follow_groups

    count, joints = len(motion.counts), len(problem.robot.snare)
    poses, edges = lay_motion(problem, motion)
    groups, steps = len(poses.lengths), int(motion.counts.max()) + 1
    tracks = Track(
        make_lanes(groups, steps, 6 * joints), make_lanes(groups, steps, 9),
        make_lanes(groups, steps, 1), make_lanes(groups, 2, 1),
    )  # fmt: skip
    tracks.wrenches[:, 0] = lay_rows(motion.wrenches.reshape(count, -1))
    tracks.totals[:] = np.nan
    rules = Rules(
        parameters.tolerance_mm / problem.unit_mm,
        parameters.integration_error_mm / problem.unit_mm,
        parameters.largest_bend_rad,
        parameters.iterations,
        parameters.steps_between_checks,
        is_exact,
        from_rest,
    )
    follow_groups(problem.robot, poses, edges, tracks, rules, *make_room(joints))
    wrenches, tips, totals, signs = (gather_rows(laid, count) for laid in tracks)
    if steps > 2 and not from_rest:  # the second step shows whether the first one jumped
        is_open = (motion.counts > 1) & ~(totals[:, 2, 0] < rules.tolerance)
        totals[is_open, 1] = np.inf
    return Found(wrenches.reshape(count, steps, joints, 6), tips, totals[..., 0]), signs[..., 0]


def count_true(flags: np.ndarray) -> np.ndarray:
    """Return how many flags (edge, step) of each edge are true before the first that is not."""
    return np.where(flags.all(1), flags.shape[1], (~flags).argmax(1))


def lay_motion(problem: Problem, motion: Motion) -> tuple["Pose", "Edges"]:
    """Return the start and one step of edges, in lanes and in the problem's units."""
    from scipy.spatial.transform import Rotation

    from nodes.kernels.crisp_straight_edges import Edges
    from nodes.kernels.crisp_straight_residual import Pose

    count, unit = len(motion.counts), problem.unit_mm
    cut = np.maximum(motion.counts, 1)[:, None]
    turns = Rotation.from_rotvec((motion.turns / cut[..., None]).reshape(-1, 3)).as_matrix()
    ends = motion.lengths + motion.growths
    near, far = find_grasps(problem.setup, np.stack([motion.lengths, ends]))
    axes = motion.frames[..., [2, 0]].swapaxes(-1, -2)
    poses = Pose(
        lay_rows(axes.reshape(count, -1)), lay_rows(motion.lengths / unit), lay_rows(near / unit)
    )
    edges = Edges(
        lay_rows(turns.reshape(count, -1)),
        lay_rows(motion.growths / cut / unit),
        lay_rows((far - near) / cut / unit),
        lay_rows(motion.counts[:, None], filling=-1.0),
    )
    return poses, edges


def lay_rows(values: np.ndarray, filling: float = 0.0) -> np.ndarray:
    """Return (group, row, lane) of (edge, row); the last group is filled up."""
    from nodes.kernels.crisp_lanes import LANES, make_lanes

    count, rows = values.shape
    groups = -(-count // LANES)
    padded = np.full((groups * LANES, rows), filling)
    padded[:count] = values
    laid = make_lanes(groups, rows)
    laid[:] = padded.reshape(groups, LANES, rows).transpose(0, 2, 1)
    return laid


def gather_rows(laid: np.ndarray, count: int) -> np.ndarray:
    """Return (edge, step, row) of (group, step, row, lane)."""
    groups, steps, rows, lanes = laid.shape
    return laid.transpose(0, 3, 1, 2).reshape(groups * lanes, steps, rows)[:count]


def make_room(joints: int) -> tuple["Solver", "Workspace"]:
    """Return where the kernels write as they go, for so many joints."""
    from nodes.kernels.crisp_lanes import LANES, make_lanes
    from nodes.kernels.crisp_straight_newton import PATIENCE, Solver
    from nodes.kernels.crisp_straight_residual import SITE_ROWS, Workspace
    from nodes.kernels.crisp_straight_rod import ROD_ROWS

    rows = 6 * joints
    vectors = [make_lanes(rows) for _ in range(6)]
    inverse, jacobian, product = (make_lanes(rows * rows) for _ in range(3))
    solver = Solver(
        *vectors, inverse, jacobian, make_lanes(36), make_lanes(6 * rows), make_lanes(PATIENCE),
        product, np.zeros(LANES), np.empty((rows, 2 * rows)), np.empty(2 * joints, np.int64),
        make_lanes(1),
    )  # fmt: skip
    sites = SITE_ROWS * joints
    return solver, Workspace(
        make_lanes(ROD_ROWS), make_lanes(sites), make_lanes(sites), make_lanes(9)
    )
