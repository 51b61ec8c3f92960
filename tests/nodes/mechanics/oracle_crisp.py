"""CRISP robots, slowly: all base wrenches sought at once, from anywhere.

Grasps, and a free tip of the tool, are equations in the 6 n base wrenches, solved by SciPy's root
and Newton's method, with derivatives from complex steps through the integrator.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from tests.nodes.mechanics.oracle_crisp_rods import LOOSE, TIGHT, Robot, frame_of, robot_of, shoot

COMPLEX_STEP = 1e-30


@dataclass(frozen=True)
class CrispAtRest:
    """One equilibrium in world axes."""

    base_wrenches: np.ndarray  # (rod, 6) moment first
    tip_point: np.ndarray
    tip_frame: np.ndarray
    residual: float
    elastic_energy: float
    pieces: tuple = field(repr=False)

    def points(self, rod: int, arcs: np.ndarray) -> np.ndarray:
        """Return (n, 3) places of a rod's axis at arc lengths from its entry point."""
        return np.array([_at(self.pieces[rod], arc)[:3] for arc in arcs]).real

    def frame(self, rod: int, arc: float) -> np.ndarray:
        """Return the (3, 3) rotation from body to world there."""
        return frame_of(_at(self.pieces[rod], arc)[3:7].real[:, None])[..., 0]


def _at(pieces, arc):
    for piece in pieces:
        if arc <= piece.t_max:
            break
    return piece(arc).reshape(14, -1)[:, 0]


def _units(robot):
    """Return what each equation is divided by, so that all are of ordinary size."""
    moment, force, length = robot.scale[0], robot.scale[3], robot.lengths[0]
    units = []
    for joint in robot.joints:
        units += [length] * 3 + ([1.0] * 3 if joint.rigid else [1.0, moment, moment])
    return np.array([*units, *[moment] * 3, *[force] * 3])


def solve(robot: Robot, start: np.ndarray | None = None) -> CrispAtRest | None:
    """Return the equilibrium that a search from these base wrenches (rod, 6) ends in, if any."""
    start = np.zeros((len(robot.lengths), 6)) if start is None else start
    size = np.tile(robot.scale, len(robot.lengths))
    try:
        found = root(lambda x: _linearise(robot, x * size, LOOSE), np.ravel(start) / size, jac=True)
    except (ValueError, np.linalg.LinAlgError):  # it ran off to where nothing is finite
        return None
    if not np.abs(found.fun).max() < 1e3 * LOOSE:
        return None
    polished = polish(robot, (found.x * size).reshape(-1, 6))
    return None if polished is None or _is_upside_down(robot, polished) else polished


def polish(robot: Robot, wrenches: np.ndarray, steps: int = 6) -> CrispAtRest | None:
    """Return the equilibrium beside almost right base wrenches (rod, 6), by Newton's method."""
    size = np.tile(robot.scale, len(robot.lengths))
    for _ in range(steps):
        values, slope = _linearise(robot, wrenches.ravel(), TIGHT)
        move = np.linalg.solve(slope, values) * size
        wrenches = wrenches - move.reshape(-1, 6)
        if np.abs(move / size).max() < 1e-9:  # what is left is its square
            return at_rest(robot, wrenches)
    return None


def _linearise(robot, wrenches, tolerance):
    """Return the equations and their Jacobian, all in units of ordinary size."""
    size, units = np.tile(robot.scale, len(robot.lengths)), _units(robot)
    columns = wrenches[:, None] + 1j * COMPLEX_STEP * np.diag(size)
    values = shoot(robot, columns, tolerance)[0] / units[:, None]
    return values[:, 0].real, values.imag / COMPLEX_STEP


def at_rest(robot: Robot, wrenches: np.ndarray) -> CrispAtRest:
    """Return the shape that base wrenches (rod, 6) give, whether the grasps hold or not."""
    values, ends, pieces = shoot(robot, wrenches.reshape(-1, 1))
    tool = ends[0][:, 0]
    return CrispAtRest(
        wrenches,
        tool[:3],
        frame_of(tool[3:7, None])[..., 0],
        float(np.abs(values[:, 0] / _units(robot)).max()),
        float(sum(end[13, 0] for end in ends)),
        tuple(pieces),
    )


def _is_upside_down(robot, at_rest):
    """Tell the spurious roots of rigid grasps, half a turn away from the frame that is meant."""
    for joint in robot.joints:
        tool = at_rest.frame(0, joint.arc)
        snare = at_rest.frame(joint.snare, robot.lengths[joint.snare])
        if joint.rigid and min(tool[:, 0] @ snare[:, 0], tool[:, 2] @ snare[:, 1]) < 0.9:
            return True
    return False


def balance(robot: Robot, at_rest: CrispAtRest) -> float:
    """Return the worst sum of forces, N, and of moments about the origin, N mm, on the whole."""
    moments, forces = at_rest.base_wrenches[:, :3], at_rest.base_wrenches[:, 3:]
    force = -forces.sum(0)
    moment = -(moments + np.cross(robot.entry, forces)).sum(0)
    for arc, push, twist in robot.loads:
        place = at_rest.points(0, np.array([arc]))[0]
        force, moment = force + push, moment + twist + np.cross(place, push)
    return float(max(np.abs(force).max(), np.abs(moment).max()))


def camera_jacobian(setup, configuration, at_rest: CrispAtRest, step: float = 1e-4) -> np.ndarray:
    """Return (6, 4 rod) d(place mm, rotation vector rad, world axes) of the tool's tip, rod by rod
    by a rotation vector in world axes and the length, by central differences of whole solves."""
    columns = []
    for rod, axis in np.ndindex(len(configuration.lengths_mm), 4):
        ends = []
        for way in (step, -step):
            frames, lengths = (
                configuration.patient_from_entry.copy(),
                configuration.lengths_mm.copy(),
            )
            if axis < 3:
                frames[rod] = Rotation.from_rotvec(way * np.eye(3)[axis]).as_matrix() @ frames[rod]
            else:
                lengths[rod] += way
            moved = replace(configuration, patient_from_entry=frames, lengths_mm=lengths)
            ends.append(polish(robot_of(setup, moved), at_rest.base_wrenches))
        turn = Rotation.from_matrix(ends[0].tip_frame @ ends[1].tip_frame.T).as_rotvec()
        columns.append(np.concatenate([ends[0].tip_point - ends[1].tip_point, turn]) / (2 * step))
    return np.stack(columns, 1)


def all_solutions(robot: Robot, starts: int = 10, seed: int = 0, spread: float = 2.0):
    """Return the different equilibria that searches from random base wrenches end in, the one of
    least elastic energy first."""
    chance = np.random.default_rng(seed)
    found: list[CrispAtRest] = []
    for number in range(starts):
        start = chance.normal(0, spread * (number > 0), (len(robot.lengths), 6)) * robot.scale
        at_rest = solve(robot, start)
        if at_rest is not None and all(
            np.abs((at_rest.base_wrenches - other.base_wrenches) / robot.scale).max() > 1e-6
            for other in found
        ):
            found.append(at_rest)
    return sorted(found, key=lambda at_rest: at_rest.elastic_energy)
