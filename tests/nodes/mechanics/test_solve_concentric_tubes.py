"""One configuration of concentric tubes: reference cases, closed forms, Jacobian."""

from dataclasses import replace

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.mechanics.solve_concentric_tubes import solve_concentric_tubes
from tests.nodes.mechanics.concentric_reference import (
    equal_tubes,
    joint_values,
    reference_cases,
    reference_joints,
    reference_robot,
    tubes_of,
)

CASES = reference_cases()
TIP = (slice(0, 3), 3)


def solve(robot, rotations, translations, **more):
    return solve_concentric_tubes(robot, joint_values(rotations, translations), **more)


def at_places(solution, places):
    return [int(np.abs(solution.arc_lengths_mm - place).argmin()) for place in places]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["robot"])
def test_reference_cases_are_met(case):
    robot, joints = reference_robot(case), reference_joints(case)
    found = solve_concentric_tubes(robot, joints, arc_lengths_mm=np.array(case["s"]))
    rows = at_places(found, case["s"])
    assert found.status == "solved" and found.reason == ""
    np.testing.assert_allclose(found.points_patient_mm[rows], case["P"], atol=1e-6, rtol=0)
    np.testing.assert_allclose(found.patient_from_tip[TIP], case["tip_p"], atol=1e-6, rtol=0)
    tip_frame = found.patient_from_tip[:3, :3]
    np.testing.assert_allclose(tip_frame, case["tip_R_bishop"], atol=1e-8)
    np.testing.assert_allclose(found.tip_angles_rad, case["psi_tip"], atol=1e-9)
    np.testing.assert_allclose(found.entry_angles_rad, case["psi0"], atol=1e-9)
    np.testing.assert_allclose(found.entry_twists_per_mm, case["uz0"], atol=1e-11)
    np.testing.assert_allclose(found.angles_rad[rows], case["psi_at_s"], atol=1e-9)
    assert found.one_solution


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["robot"])
def test_least_determinant_is_that_of_the_reference(case):
    """The reference looked on a grid over all rotations; one case has less off the corners."""
    found = solve_concentric_tubes(reference_robot(case), reference_joints(case))
    off_corner = case["min_det"] == pytest.approx(0.727115509790613)
    assert found.least_determinant == pytest.approx(
        case["min_det"], abs=0.02 if off_corner else 1e-7
    )


def differences(robot, joints, step=1e-5):
    """Central differences of place and frame of the tip by all joint values."""
    count = len(robot.tubes)
    tips = solve_concentric_tubes(robot, joints).tip_angles_rad
    columns = []
    for joint in range(2 * count):
        poses = []
        for way in (step, -step):
            values = np.concatenate([joints.rotations_rad, joints.translations_mm])
            values[joint] += way
            moved = joint_values(values[:count], values[count:])
            poses.append(solve_concentric_tubes(robot, moved, tips).patient_from_tip)
        change = (poses[0] - poses[1]) / (2 * step)
        turn = change[:3, :3] @ ((poses[0] + poses[1]) / 2)[:3, :3].T
        rotation = [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
        columns.append(np.concatenate([change[:3, 3], np.array(rotation) / 2]))
    return np.array(columns).T


@pytest.mark.parametrize(
    "case", [case for case in CASES if "tip_jac" in case], ids=lambda case: case["robot"]
)
def test_jacobian_is_that_of_the_reference(case):
    found = solve_concentric_tubes(reference_robot(case), reference_joints(case)).tip_jacobian
    expected = np.array(case["tip_jac"])
    for rows in (slice(0, 3), slice(3, 6)):
        scale = np.abs(expected[rows]).max()
        np.testing.assert_allclose(found[rows], expected[rows], atol=1e-5 * scale, rtol=0)


@pytest.mark.parametrize("number", [2, 9, 12, 20])
def test_jacobian_is_the_limit_of_differences_in_any_pose_of_the_base(number):
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = [[0, 0, 1], [1, 0, 0], [0, 1, 0]], [5, -7, 30]
    robot, joints = reference_robot(CASES[number], base), reference_joints(CASES[number])
    expected = differences(robot, joints, 1e-3)
    found = solve_concentric_tubes(robot, joints).tip_jacobian
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max(), rtol=0)


def test_one_tube_is_an_arc():
    found = solve(tubes_of((60.0, 40.0, 0.02)), [0.7], [-50.0])
    out = (1 - np.cos(0.8)) / 0.02
    arc = [out * np.cos(0.7), out * np.sin(0.7), 10 + np.sin(0.8) / 0.02]
    np.testing.assert_allclose(found.patient_from_tip[TIP], arc, atol=1e-9)
    assert found.determinant == found.least_determinant == 1.0


@pytest.mark.parametrize("angle", [0.0, np.pi])
def test_tubes_in_one_plane_share_their_curvature_by_stiffness(angle):
    robot = tubes_of((40.0, 30.0, 0.012), (40.0, 30.0, 0.009))
    found = solve(robot, [0.4, 0.4 + angle], [-30.0, -30.0])
    inner, outer = (tube.bending_stiffness for tube in robot.tubes)
    bend = (inner * 0.012 + np.cos(angle) * outer * 0.009) / (inner + outer)
    out = (1 - np.cos(30 * bend)) / bend
    arc = [out * np.cos(0.4), out * np.sin(0.4), 10 + np.sin(30 * bend) / bend]
    np.testing.assert_allclose(found.patient_from_tip[TIP], arc, atol=1e-8)


def test_tubes_that_do_not_twist_keep_the_angles_of_their_bases():
    """A Poisson's ratio of -1 is out of reach, but a short straight transmission comes near."""
    robot = equal_tubes((1.0, 5.0, 0.002), (1.0, 5.0, 0.002))
    found = solve(robot, [0.0, 2.0], [-1.0, -1.0])
    np.testing.assert_allclose(found.tip_angles_rad, [0.0, 2.0], atol=2e-4)
    assert found.determinant == pytest.approx(1.0, abs=2e-4)


def test_moments_about_the_axis_cancel_everywhere():
    robot = reference_robot(CASES[12])
    places = np.linspace(0, 80, 400)
    found = solve_concentric_tubes(robot, reference_joints(CASES[12]), arc_lengths_mm=places)
    stiffness = np.array([tube.torsional_stiffness for tube in robot.tubes])
    swing = found.angles_rad - found.tip_angles_rad
    assert np.abs(swing).max() > 0.01
    np.testing.assert_allclose(swing @ stiffness / stiffness.sum(), 0.0, atol=1e-12)
    assert stiffness @ found.entry_twists_per_mm == pytest.approx(0.0, abs=1e-12)


def test_whole_turns_of_a_base_turn_tip_and_entry_alike():
    robot, joints = reference_robot(CASES[12]), reference_joints(CASES[12])
    once = solve_concentric_tubes(robot, joints)
    turned = joints.rotations_rad + 2 * np.pi * np.array([0, 1, -2])
    again = solve_concentric_tubes(robot, replace(joints, rotations_rad=turned))
    np.testing.assert_allclose(again.patient_from_tip, once.patient_from_tip, atol=1e-9)
    more = again.tip_angles_rad - once.tip_angles_rad
    np.testing.assert_allclose(more, 2 * np.pi * np.array([0, 1, -2]), atol=1e-9)


def test_curvature_below_zero_is_curvature_turned_round():
    plus = tubes_of((40.0, 40.0, 0.012), (30.0, 30.0, 0.009))
    minus = tubes_of((40.0, 40.0, 0.012), (30.0, 30.0, -0.009))
    one = solve(plus, [0.3, 1.1], [-30.0, -10.0])
    other = solve(minus, [0.3, 1.1 - np.pi], [-30.0, -10.0])
    np.testing.assert_allclose(other.patient_from_tip, one.patient_from_tip, atol=1e-9)
    np.testing.assert_allclose(other.tip_angles_rad, one.tip_angles_rad - [0, np.pi], atol=1e-9)


def test_breaks_that_coincide_are_the_limit_of_near_ones():
    """The curves of tubes 1 and 2 start where tube 3 ends."""
    robot = tubes_of((50.0, 40.0, 0.012), (40.0, 35.0, 0.009), (10.0, 20.0, 0.006))
    rotations, at = [0.3, 1.1, -0.8], np.array([-30.0, -20.0, -10.0])
    together = solve(robot, rotations, at)
    near = solve(robot, rotations, at + np.array([0.0, 1e-7, -2e-7]))
    np.testing.assert_allclose(together.patient_from_tip, near.patient_from_tip, atol=1e-6)
    # Breaks stay in the order of the tubes if the first is pushed out or the last drawn back.
    for joint, way in ((0, 1e-4), (2, -1e-4)):
        moved = solve(robot, rotations, at + way * np.eye(3)[joint])
        change = (moved.patient_from_tip - together.patient_from_tip)[TIP] / way
        np.testing.assert_allclose(change, together.tip_jacobian[:3, 3 + joint], atol=2e-5)


def test_a_robot_drawn_in_has_its_tip_at_the_base():
    found = solve(tubes_of((40.0, 40.0, 0.012), (40.0, 30.0, 0.009)), [0.3, 1.1], [-80.0, -70.0])
    np.testing.assert_allclose(found.patient_from_tip, np.eye(4), atol=1e-12)
    np.testing.assert_allclose(found.tip_angles_rad, [0.3, 1.1], atol=1e-12)
    np.testing.assert_allclose(found.tip_jacobian[:3, 2], [0, 0, 1], atol=1e-12)


def test_joint_values_out_of_order_are_refused():
    with pytest.raises(BadInput, match="translations"):
        solve(tubes_of((40.0, 40.0, 0.012), (40.0, 30.0, 0.009)), [0.3, 1.1], [-10.0, -20.0])
