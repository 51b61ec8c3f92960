"""Concentric tubes, slowly: from the base to the tips, as a boundary value problem.

Rucker's equations [Rucker2010] in each tube's own material frame, integrated with DOP853 section by
section; the twists at the base are what is sought, so that no twist is left at the tips. Nothing
here is shared with the project's own solver, which begins at the tips.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

from nodes.mechanics.robots import ConcentricTubeConfiguration, ConcentricTubeRobot

TIGHT, LOOSE = 1e-12, 1e-6  # relative tolerances of the integration


@dataclass(frozen=True)
class Section:
    """Arc lengths between which no tube ends and none becomes curved, and what is there."""

    begin: float
    end: float
    present: np.ndarray
    curvature: np.ndarray


@dataclass(frozen=True)
class TubesAtRest:
    """One equilibrium, in base axes: twists at the base, angles, Bishop frame of the tip."""

    base_twists: np.ndarray
    base_angles: np.ndarray
    tip_angles: np.ndarray
    tip_point: np.ndarray
    tip_frame: np.ndarray
    residual: float
    dense: tuple

    def points(self, arcs: np.ndarray) -> np.ndarray:
        """Return (n, 3) places of the backbone at arc lengths from the entry plane."""
        return np.array([self._state(arc)[-12:-9] for arc in arcs])

    def twists(self, arcs: np.ndarray) -> np.ndarray:
        """Return (n, tube) u_iz at arc lengths from the entry plane."""
        count = len(self.base_twists)
        return np.array([self._state(arc)[count : 2 * count] for arc in arcs])

    def _state(self, arc):
        for piece in self.dense:
            if arc <= piece.t_max:
                return piece(arc)
        return self.dense[-1](arc)


def stiffness(robot: ConcentricTubeRobot) -> tuple[np.ndarray, np.ndarray]:
    """Return E I and G J of each tube, N mm^2."""
    bending, torsion = [], []
    for tube in robot.tubes:
        second = np.pi * (tube.outer_diameter_mm**4 - tube.inner_diameter_mm**4) / 64
        shear = tube.material.young_modulus_mpa / (2 * (1 + tube.material.poisson_ratio))
        bending.append(tube.material.young_modulus_mpa * second)
        torsion.append(shear * 2 * second)
    return np.array(bending), np.array(torsion)


def tips(robot: ConcentricTubeRobot, translations: np.ndarray) -> np.ndarray:
    """Return the arc length at which each tube ends, mm."""
    return np.array([tube.length_mm for tube in robot.tubes]) + translations


def sections(robot: ConcentricTubeRobot, translations: np.ndarray) -> list[Section]:
    """Cut the robot outside of its base where a tube ends or becomes curved."""
    ends = tips(robot, translations)
    starts = np.array([tube.straight_length_mm for tube in robot.tubes]) + translations
    curvature = np.array([tube.curvature_per_mm for tube in robot.tubes])
    breaks = np.unique(np.clip(np.concatenate([[0.0], starts, ends]), 0.0, None))
    cut = []
    for begin, end in pairwise(breaks):
        middle = (begin + end) / 2
        cut.append(Section(begin, end, ends > middle, np.where(starts < middle, curvature, 0.0)))
    return cut


def _rate(section, bending, torsion):
    """Return d/ds of (angles, twists, place, Bishop frame); a tube that has ended stays."""
    count = len(bending)

    def rate(_, state):
        angles, twists = state[:count], state[count : 2 * count]
        frame = state[-9:].reshape(3, 3)
        axes = np.stack([-np.sin(angles), np.cos(angles)], 1)  # each tube's own y in the frame
        own = np.stack([np.cos(angles), np.sin(angles)], 1)  # and its x
        held = section.present * bending
        bend = (held * section.curvature) @ axes / held.sum()
        twist_rate = section.present * bending / torsion * section.curvature * (own @ bend)
        turn = np.array([[0, 0, bend[1]], [0, 0, -bend[0]], [-bend[1], bend[0], 0]])
        angle_rate = section.present * twists
        return np.concatenate([angle_rate, twist_rate, frame[:, 2], (frame @ turn).ravel()])

    return rate


def shoot(robot, configuration, base_twists, tolerance=TIGHT):
    """Integrate from the base; return the last state, the twists left at the tips, the pieces."""
    bending, torsion = stiffness(robot)
    translations, count = configuration.translations_mm, len(bending)
    angles = configuration.rotations_rad - translations * base_twists
    state = np.concatenate([angles, base_twists, np.zeros(3), np.eye(3).ravel()])
    pieces = []
    for section in sections(robot, translations):
        found = solve_ivp(
            _rate(section, bending, torsion),
            (section.begin, section.end),
            state,
            "DOP853",
            rtol=tolerance,
            atol=1e-3 * tolerance,
            dense_output=True,
        )
        state = found.y[:, -1]
        pieces.append(found.sol)
    return state, state[count : 2 * count], tuple(pieces)


def solve(
    robot: ConcentricTubeRobot, configuration: ConcentricTubeConfiguration, start=None
) -> TubesAtRest | None:
    """Return an equilibrium, None where the search from these twists at the base finds none.

    Parameters
    ----------
    start : (tube,) twists times lengths from which to search, rad; none if not given.
    """
    lengths = np.array([tube.length_mm for tube in robot.tubes])
    start = np.zeros(len(lengths)) if start is None else np.asarray(start)
    for tolerance in (LOOSE, TIGHT):
        found = root(
            lambda x, tolerance=tolerance: (
                shoot(robot, configuration, x / lengths, tolerance)[1] * lengths
            ),
            start,
            tol=1e-14 if tolerance == TIGHT else 1e-7,
        )
        start = found.x
        if not np.abs(found.fun).max() < 100 * tolerance:
            return None
    return _at_rest(robot, configuration, start / lengths)


def _at_rest(robot, configuration, twists):
    state, left, pieces = shoot(robot, configuration, twists)
    count = len(twists)
    return TubesAtRest(
        twists,
        configuration.rotations_rad - configuration.translations_mm * twists,
        state[:count],
        state[-12:-9],
        state[-9:].reshape(3, 3),
        float(np.abs(left).max()),
        pieces,
    )


def all_solutions(robot, configuration, starts=20, seed=0) -> list[TubesAtRest]:
    """Return the different equilibria that searches from random twists at the base end in."""
    chance = np.random.default_rng(seed)
    found: list[TubesAtRest] = []
    for number in range(starts):
        start = chance.normal(0, 2.0 * (number > 0), len(robot.tubes))
        solution = solve(robot, configuration, start)
        if solution is not None and all(
            np.abs(solution.tip_angles - other.tip_angles).max() > 1e-6 for other in found
        ):
            found.append(solution)
    return found


def rotations_of(robot, translations, tip_angles, tolerance=TIGHT) -> np.ndarray:
    """Return the rotations theta at the base that end in these angles alpha at the tips, rad."""
    bending, torsion = stiffness(robot)
    count, ends = len(bending), tips(robot, translations)
    state = np.concatenate([tip_angles, np.zeros(count), np.zeros(3), np.eye(3).ravel()])
    for section in reversed(sections(robot, translations)):
        state = solve_ivp(
            _rate(section, bending, torsion),
            (section.end, section.begin),
            state,
            "DOP853",
            rtol=tolerance,
            atol=1e-3 * tolerance,
        ).y[:, -1]
    assert (ends >= 0).all()
    return state[:count] + translations * state[count : 2 * count]


def stability(robot, translations, tip_angles, step=1e-4) -> float:
    """Return det d theta / d alpha by central differences; positive on the branch that grows from
    an unbent robot."""
    count = len(robot.tubes)
    columns = [
        (rotations_of(robot, translations, tip_angles + push))
        - (rotations_of(robot, translations, tip_angles - push))
        for push in step * np.eye(count)
    ]
    return float(np.linalg.det(np.stack(columns, 1) / (2 * step)))


def tip_jacobian(robot, configuration, solution, step=1e-4) -> np.ndarray:
    """Return (6, 2 tube) d(place mm, rotation vector rad in base axes) / d(theta, beta), by central
    differences of whole solves."""
    values = np.concatenate([configuration.rotations_rad, configuration.translations_mm])
    count = len(robot.tubes)
    lengths = np.array([tube.length_mm for tube in robot.tubes])
    columns = []
    for push in step * np.eye(2 * count):
        ends = [
            solve(
                robot,
                ConcentricTubeConfiguration((values + way)[:count], (values + way)[count:]),
                solution.base_twists * lengths,
            )
            for way in (push, -push)
        ]
        turn = ends[0].tip_frame @ ends[1].tip_frame.T
        vector = np.array(
            [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
        )
        columns.append(np.concatenate([ends[0].tip_point - ends[1].tip_point, vector / 2]))
    return np.stack(columns, 1) / (2 * step)
