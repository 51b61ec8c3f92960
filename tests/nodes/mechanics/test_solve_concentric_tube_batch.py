"""Batches against single solutions, branches, and insertions with one solution."""

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.mechanics.concentric_tube_solution import STATUSES
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

TRIO = reference_robot(reference_cases()[12])
DUO = reference_robot(reference_cases()[1])


def test_points_lie_on_the_backbone_of_the_single_solution():
    rotations, translations = random_joints(np.random.default_rng(3), TRIO, 12)
    batch = solve_concentric_tube_batch(TRIO, rotations, translations, samples=50)
    for row in np.flatnonzero(batch.status == 0):
        joints, tips = joint_values(rotations[row], translations[row]), batch.tip_angles_rad[row]
        places = batch.arc_lengths_mm[row]
        alone = solve_concentric_tubes(TRIO, joints, tips, places)
        rows = np.searchsorted(alone.arc_lengths_mm, places - 1e-9)
        points = alone.points_patient_mm[rows]
        np.testing.assert_allclose(batch.points_patient_mm[row], points, atol=1e-6)
        np.testing.assert_allclose(batch.points_patient_mm[row, -1], points[-1], atol=1e-6)


@pytest.mark.parametrize("robot", [DUO, TRIO], ids=["two tubes", "three tubes"])
def test_insertions_with_one_solution_are_always_solved(robot):
    rotations, translations = random_joints(np.random.default_rng(4), robot, 600)
    batch = solve_concentric_tube_batch(robot, rotations, translations, with_uniqueness=True)
    assert 100 < batch.one_solution.sum() < 600
    assert (batch.status[batch.one_solution] == 0).all()
    assert (batch.residual_rad[batch.one_solution] < 1e-3).all()
    assert (batch.determinant[batch.one_solution] > 0).all()


def test_bases_follow_from_the_tip_angles_found():
    """Held against integration from the tip with a solver of scipy's."""
    from scipy.integrate import solve_ivp

    curvature, length = 0.02, 60.0
    robot = equal_tubes((0.0, length, curvature), (0.0, length, curvature))
    rotations = np.array([[0.0, 1.0], [0.0, 2.0], [0.0, 3.0]])
    batch = solve_concentric_tube_batch(robot, rotations, np.zeros((3, 2)))
    wave = 1.3 * curvature**2  # phi'' = (1 + nu) kappa^2 sin(phi) for equal tubes
    for row in range(3):
        apart = np.diff(batch.tip_angles_rad[row])[0]
        swing = solve_ivp(
            lambda _, y: [y[1], wave * np.sin(y[0])], (0, length), [apart, 0.0],
            rtol=1e-12, atol=1e-12,
        )  # fmt: skip
        assert swing.y[0, -1] == pytest.approx(rotations[row, 1], abs=1e-9)


def test_a_warm_start_keeps_its_branch_beyond_the_critical_length():
    curved = 1.2 * np.pi / 2 / np.sqrt(1.3 * 0.02**2)
    robot = equal_tubes((0.0, curved, 0.02), (0.0, curved, 0.02))
    ends = {}
    for way in (1, -1):
        tips = None
        for angle in np.linspace(0, np.pi, 60):
            rotations = np.array([[0.0, way * angle]])
            batch = solve_concentric_tube_batch(robot, rotations, np.zeros((1, 2)), tips)
            tips = batch.tip_angles_rad
        assert STATUSES[batch.status[0]] == "solved"
        ends[way] = np.diff(tips[0])[0]
    # Turned to pi and to -pi the robot stands in two shapes, each the other's mirror image.
    assert ends[1] == pytest.approx(-ends[-1], abs=1e-8)
    assert 0.3 < ends[1] < np.pi - 0.3


def test_the_opposed_equilibrium_is_unstable_beyond_the_critical_length():
    for share, status in ((0.99, "solved"), (1.01, "unstable")):
        curved = share * np.pi / 2 / np.sqrt(1.3 * 0.02**2)
        robot = equal_tubes((0.0, curved, 0.02), (0.0, curved, 0.02))
        joints, tips = np.array([[0.0, np.pi]]), np.array([[0.0, np.pi]])
        batch = solve_concentric_tube_batch(robot, joints, np.zeros((1, 2)), tips)
        assert STATUSES[batch.status[0]] == status


def test_impossible_joint_values_have_no_solution_and_harm_no_other():
    rotations, translations = random_joints(np.random.default_rng(5), DUO, 4)
    good = solve_concentric_tube_batch(DUO, rotations, translations)
    bad_rotations, bad = rotations.copy(), translations.copy()
    bad[0, 1], bad[1, 0], bad_rotations[2, 0] = 1.0, -151.0, np.nan
    batch = solve_concentric_tube_batch(DUO, bad_rotations, bad, samples=3, with_jacobian=True)
    assert [STATUSES[one] for one in batch.status[:3]] == ["no solution"] * 3
    assert np.isnan(batch.patient_from_tip[:3, :3, 3]).all()
    np.testing.assert_allclose(batch.patient_from_tip[3], good.patient_from_tip[3], atol=1e-6)


def test_the_same_joint_values_give_the_same_bytes():
    rotations, translations = random_joints(np.random.default_rng(6), TRIO, 5)
    one, same = (solve_concentric_tube_batch(TRIO, rotations, translations) for _ in range(2))
    assert one.patient_from_tip.tobytes() == same.patient_from_tip.tobytes()


@pytest.mark.parametrize("short", ["rotations", "tips"])
def test_arrays_of_other_lengths_are_refused(short):
    robot = tubes_of((80.0, 60.0, 0.02), (50.0, 40.0, 0.012))
    rotations, translations = random_joints(np.random.default_rng(0), robot, 5)
    tips = np.zeros((3, 2)) if short == "tips" else None
    rows = rotations if short == "tips" else rotations[:3]
    with pytest.raises(BadInput, match="of shape"):
        solve_concentric_tube_batch(robot, rows, translations, tips)


def test_tips_that_coincide_but_for_rounding_are_in_order():
    robot = tubes_of((80.0, 60.0, 0.02), (50.0, 40.0, 0.012))
    translations = np.array([[-76.4, -26.4]])
    assert translations[0, 0] + 140 < translations[0, 1] + 90
    batch = solve_concentric_tube_batch(robot, np.zeros((1, 2)), translations)
    assert batch.status[0] == 0
