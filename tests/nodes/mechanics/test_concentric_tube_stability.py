"""Stability of insertions: the closed form for two tubes, dense grids for three."""

from itertools import pairwise

import numpy as np
import pytest

from nodes.mechanics.follow_concentric_tubes import follow_concentric_tubes
from nodes.mechanics.solve_concentric_tube_batch import solve_concentric_tube_batch
from nodes.mechanics.solve_concentric_tubes import solve_concentric_tubes
from tests.nodes.mechanics.concentric_reference import (
    equal_tubes,
    joint_values,
    random_joints,
    reference_cases,
    reference_robot,
    tubes_of,
)


def closed_form(robot, translations):
    """cos(w l) - w b sin(w l), b the straight length upstream weighted by compliance."""
    inner, outer = robot.tubes
    straight = np.array([inner.straight_length_mm, outer.straight_length_mm])
    start = max(0.0, *(translations + straight))
    length = max(outer.length_mm + translations[1] - start, 0.0)
    bending = np.array([inner.bending_stiffness, outer.bending_stiffness])
    compliance = 1 / np.array([inner.torsional_stiffness, outer.torsional_stiffness])
    curved = bending * [inner.curvature_per_mm, outer.curvature_per_mm]
    wave = np.sqrt(curved.prod() / bending.sum() * compliance.sum())
    upstream = (start - translations) @ compliance / compliance.sum()
    return np.cos(wave * length) - wave * upstream * np.sin(wave * length)


def test_two_tubes_have_the_determinant_of_the_closed_form():
    robot = tubes_of((80.0, 60.0, 0.02), (50.0, 40.0, 0.012))
    rotations, translations = random_joints(np.random.default_rng(0), robot, 60)
    batch = solve_concentric_tube_batch(robot, rotations, translations, with_uniqueness=True)
    expected = [min(closed_form(robot, row), 1.0) for row in translations]
    assert min(expected) < 0 < max(expected)
    seen = np.array(expected) > 0
    np.testing.assert_array_equal(batch.one_solution, seen)
    np.testing.assert_allclose(batch.least_determinant[seen], np.array(expected)[seen], atol=1e-10)


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_two_equal_tubes_bifurcate_at_the_critical_length(share):
    """With straight parts of length b upstream, cos(w l) = w b sin(w l) there."""
    from scipy.optimize import brentq

    wave, straight = np.sqrt(1.3) * 0.02, 25.0
    critical = brentq(lambda x: np.cos(wave * x) - wave * straight * np.sin(wave * x), 1, 60)
    curved = share * critical
    robot = equal_tubes((straight, curved, 0.02), (straight, curved, 0.02))
    found = solve_concentric_tubes(robot, joint_values([0, 0.5], [-straight, -straight]))
    assert found.one_solution == (share < 1)


@pytest.mark.parametrize("turns", [1.6, 2.0, 2.2, 4.0])
def test_modes_lost_twice_are_not_forgotten(turns):
    """cos(w l) is above 0 again where w l lies beyond three quarters of a turn."""
    length = turns * np.pi / (np.sqrt(1.3) * 0.02)
    robot = equal_tubes((0.0, length, 0.02), (0.0, length, 0.02))
    found = solve_concentric_tubes(robot, joint_values([0, 0.5], [0, 0]))
    assert not found.one_solution and found.least_determinant <= 0


@pytest.mark.parametrize("share", [0.9, 0.99, 1.01, 1.1, 1.5, 1.9])
def test_three_tubes_a_third_apart_lose_two_modes_at_once(share):
    """Curvatures cancel; psi'' = -w^2 psi for both turns between tubes, w^2 = (1 + nu) k^2 / 2."""
    length = share * np.pi / 2 / (np.sqrt(1.3 / 2) * 0.02)
    robot = equal_tubes(*[(0.0, length, 0.02)] * 3)
    third = 2 * np.pi / 3 * np.arange(3)
    found = solve_concentric_tubes(robot, joint_values(third, np.zeros(3)), third)
    np.testing.assert_allclose(found.tip_angles_rad, third, atol=1e-9)
    assert found.status == ("solved" if share < 1 else "unstable")


def relative(robot, translations, apart):
    """Return the bases' angles to the innermost for tips apart so, by scipy from tip to base."""
    from scipy.integrate import solve_ivp

    tubes = robot.tubes
    bending = np.array([tube.bending_stiffness for tube in tubes])
    torsion = np.array([tube.torsional_stiffness for tube in tubes])
    kappa = np.array([tube.curvature_per_mm for tube in tubes])
    starts = translations + [tube.straight_length_mm for tube in tubes]
    tips = translations + [tube.length_mm for tube in tubes]
    breaks = np.unique(np.concatenate([[0.0], starts[starts > 0], tips]))[::-1]
    state = np.concatenate([[0.0], apart, np.zeros(len(tubes))])
    for high, low in pairwise(breaks):
        middle = (high + low) / 2
        there = middle < tips
        moments = np.where(there & (middle > starts), bending * kappa, 0.0)

        def slope(_, y, there=there, moments=moments):
            psi, count = y[: len(tubes)], len(tubes)
            pulls = np.sin(psi[:, None] - psi) @ moments * moments
            return np.concatenate([y[count:], pulls / torsion / bending[there].sum()])

        state = solve_ivp(slope, (high, low), state, rtol=1e-9, atol=1e-11).y[:, -1]
    bases = state[: len(tubes)] + translations * state[len(tubes) :]
    return bases[1:] - bases[0]


def grid_minimum(robot, translations, steps=5, h=1e-4):
    """Least determinant over a grid of tip angles, by differences."""
    angles = np.linspace(0, 2 * np.pi, 2 * steps, endpoint=False)
    dets = []
    for one in angles[: steps + 1]:
        for other in angles:
            at = np.array([one, other])
            columns = [
                relative(robot, translations, at + h * axis)
                - relative(robot, translations, at - h * axis)
                for axis in np.eye(2)
            ]
            dets.append(np.linalg.det(np.array(columns) / (2 * h)))
    return min(dets)


def test_corners_decide_for_three_tubes_as_a_grid_does():
    robot = reference_robot(reference_cases()[12])
    rotations, translations = random_joints(np.random.default_rng(8), robot, 40)
    batch = solve_concentric_tube_batch(robot, rotations, translations, with_uniqueness=True)
    chosen = np.argsort(np.abs(batch.least_determinant - 0.05))[:3]
    for row in chosen:
        least = grid_minimum(robot, translations[row])
        assert (least > 0) == batch.one_solution[row]


def test_a_motion_ends_where_the_robot_snaps():
    """Two equal tubes of curvature alone: theta(alpha) has its fold where d theta / d alpha = 0."""
    from scipy.optimize import minimize_scalar
    from scipy.special import ellipj, ellipk

    wave = np.sqrt(1.3) * 0.02
    curved = 1.2 * np.pi / 2 / wave

    def base_angle(apart):
        # phi'' = w^2 sin(phi) from rest: sin((phi - pi) / 2) is Jacobi's cd, m = cos^2(apart / 2)
        m = np.cos(apart / 2) ** 2
        sine, _, _, _ = ellipj(wave * curved + ellipk(m), m)
        return np.pi - 2 * np.arcsin(np.sqrt(m) * sine)

    fold = -minimize_scalar(
        lambda a: -base_angle(a), bounds=(0.3, np.pi - 0.05), method="bounded",
        options={"xatol": 1e-10},
    ).fun  # fmt: skip
    robot = equal_tubes((0.0, curved, 0.02), (0.0, curved, 0.02))
    start, end = joint_values([0, 0.2], [0, 0]), joint_values([0, 2 * np.pi], [0, 0])
    tips = solve_concentric_tubes(robot, start).tip_angles_rad
    motion = follow_concentric_tubes(robot, start, end, tips)
    reached = 0.2 + motion.share * (2 * np.pi - 0.2)
    assert motion.snaps
    assert np.pi < fold < 2 * np.pi
    assert reached == pytest.approx(fold, abs=2e-3)
    assert reached <= fold + 1e-6


def test_a_motion_without_a_snap_ends_at_the_solution():
    robot = reference_robot(reference_cases()[12])
    start = joint_values([0.0, 0.5, -0.5], [-80.0, -60.0, -40.0])
    end = joint_values([7.0, -2.0, 1.0], [-60.0, -50.0, -45.0])
    tips = solve_concentric_tubes(robot, start).tip_angles_rad
    motion = follow_concentric_tubes(robot, start, end, tips)
    assert not motion.snaps and motion.share == 1.0
    expected = solve_concentric_tubes(robot, end).tip_angles_rad
    np.testing.assert_allclose(motion.tip_angles_rad, expected, atol=1e-8)
