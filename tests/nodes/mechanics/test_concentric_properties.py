"""Concentric tubes against the slow solver from the base, and what holds for all of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from benchmarks.mechanics_cases import (
    random_concentric_configuration,
    random_concentric_robot,
    random_pose,
)
from nodes.mechanics.follow_concentric_tubes import follow_concentric_tubes
from nodes.mechanics.robots import ConcentricTubeConfiguration
from nodes.mechanics.solve_concentric_tube_batch import solve_concentric_tube_batch
from nodes.mechanics.solve_concentric_tubes import solve_concentric_tubes
from tests.nodes.mechanics import oracle_concentric_tubes as oracle

SEEDS = st.integers(0, 2**32 - 1)
COUNTS = st.integers(2, 4)
MIRROR = np.diag([1.0, -1.0, 1.0])


def random_case(seed, count, base=None):
    """Return a robot and a configuration whose insertion has one solution."""
    chance = np.random.default_rng(seed)
    while True:
        robot = random_concentric_robot(chance, count)
        robot = robot if base is None else replace(robot, patient_from_base=base)
        configuration = random_concentric_configuration(chance, robot)
        found = solve_concentric_tubes(robot, configuration)
        if found.one_solution:
            return robot, configuration, found


@pytest.mark.parametrize("count, seed", [(2, 0), (2, 1), (3, 0), (3, 1), (4, 0)])
def test_shape_is_what_shooting_from_the_base_finds(count, seed):
    robot, configuration, _ = random_case(seed, count)
    slow = oracle.solve(robot, configuration)
    arcs = np.linspace(0.0, slow.dense[-1].t_max, 12)
    found = solve_concentric_tubes(robot, configuration, arc_lengths_mm=arcs)
    base = robot.patient_from_base
    points = slow.points(found.arc_lengths_mm) @ base[:3, :3].T + base[:3, 3]
    frame = base[:3, :3] @ slow.tip_frame
    assert found.status == "solved"
    assert found.tip_angles_rad == pytest.approx(slow.tip_angles, abs=1e-8)
    assert np.abs(found.points_patient_mm - points).max() < 1e-6
    assert np.abs(found.patient_from_tip[:3, 3] - points[-1]).max() < 1e-6
    assert np.abs(found.patient_from_tip[:3, :3] - frame).max() < 1e-8


@pytest.mark.parametrize("count", [2, 3])
def test_jacobian_is_that_of_whole_solves_from_the_base(count):
    robot, configuration, found = random_case(7, count, np.eye(4))
    slow = oracle.tip_jacobian(robot, configuration, oracle.solve(robot, configuration))
    assert found.tip_jacobian == pytest.approx(slow, abs=1e-5 * np.abs(slow).max())


@pytest.mark.parametrize("count", [2, 3, 4])
def test_determinant_is_how_rotations_follow_tip_angles(count):
    robot, configuration, found = random_case(11, count)
    slow = oracle.stability(robot, configuration.translations_mm, found.tip_angles_rad)
    assert found.determinant == pytest.approx(slow, rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_insertion_with_one_solution_has_no_other(seed):
    robot, configuration, found = random_case(20 + seed, 3)
    (only,) = oracle.all_solutions(robot, configuration, 5)
    assert found.tip_angles_rad == pytest.approx(only.tip_angles, abs=1e-8)


@settings(max_examples=25)
@given(SEEDS, COUNTS)
def test_robot_moves_with_its_base(seed, count):
    robot, configuration, found = random_case(seed, count)
    move = random_pose(np.random.default_rng(seed))
    moved = solve_concentric_tubes(
        replace(robot, patient_from_base=move @ robot.patient_from_base), configuration
    )
    assert moved.tip_angles_rad == pytest.approx(found.tip_angles_rad, abs=1e-12)
    assert moved.patient_from_tip == pytest.approx(move @ found.patient_from_tip, abs=1e-9)
    turn = np.kron(np.eye(2), move[:3, :3])
    assert moved.tip_jacobian == pytest.approx(turn @ found.tip_jacobian, abs=1e-8)


@settings(max_examples=25)
@given(SEEDS, COUNTS, st.floats(-3, 3))
def test_turning_all_tubes_turns_the_shape(seed, count, angle):
    robot, configuration, found = random_case(seed, count, np.eye(4))
    turned = solve_concentric_tubes(
        robot, replace(configuration, rotations_rad=configuration.rotations_rad + angle)
    )
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    tip = found.patient_from_tip[:3, 3].copy()
    tip[:2] = turn @ tip[:2]
    assert turned.patient_from_tip[:3, 3] == pytest.approx(tip, abs=1e-7)
    assert turned.determinant == pytest.approx(found.determinant, rel=1e-8)


@settings(max_examples=25)
@given(SEEDS, COUNTS)
def test_mirrored_rotations_give_the_mirror_image(seed, count):
    robot, configuration, found = random_case(seed, count, np.eye(4))
    mirrored = solve_concentric_tubes(
        robot, replace(configuration, rotations_rad=-configuration.rotations_rad)
    )
    assert mirrored.patient_from_tip[:3, 3] == pytest.approx(
        MIRROR @ found.patient_from_tip[:3, 3], abs=1e-7
    )
    assert mirrored.patient_from_tip[:3, :3] == pytest.approx(
        MIRROR @ found.patient_from_tip[:3, :3] @ MIRROR, abs=1e-9
    )


@settings(max_examples=25)
@given(SEEDS, COUNTS)
def test_torques_at_the_entry_add_up_to_nothing(seed, count):
    robot, _, found = random_case(seed, count)
    torques = oracle.stiffness(robot)[1] * found.entry_twists_per_mm
    assert abs(torques.sum()) < 1e-9 * max(1.0, np.abs(torques).max())


@settings(max_examples=20)
@given(SEEDS, COUNTS)
def test_columns_of_all_rotations_add_up_to_a_turn_about_the_base(seed, count):
    _, _, found = random_case(seed, count, np.eye(4))
    whole = found.tip_jacobian[:, :count].sum(1)
    tip, tangent = found.patient_from_tip[:3, 3], found.patient_from_tip[:3, 2]
    # The tip's frame is carried along without twist, so it turns back about its own tangent.
    turn = np.eye(3)[2] - tangent
    assert whole == pytest.approx([-tip[1], tip[0], 0, *turn], abs=1e-6)


@settings(max_examples=20)
@given(SEEDS, COUNTS)
def test_warm_start_stays_at_its_solution(seed, count):
    robot, configuration, found = random_case(seed, count)
    again = solve_concentric_tubes(robot, configuration, found.tip_angles_rad)
    assert again.patient_from_tip == pytest.approx(found.patient_from_tip, abs=1e-7)


@settings(max_examples=12)
@given(SEEDS, COUNTS)
def test_way_back_ends_on_the_branch_where_it_began(seed, count):
    robot, start, found = random_case(seed, count)
    end = random_concentric_configuration(np.random.default_rng(seed + 1), robot)
    there = follow_concentric_tubes(robot, start, end, found.tip_angles_rad)
    assume(not there.snaps)
    back = follow_concentric_tubes(robot, end, start, there.tip_angles_rad)
    assert not back.snaps
    assert back.tip_angles_rad == pytest.approx(found.tip_angles_rad, abs=1e-6)


def test_batch_is_each_configuration_by_itself():
    chance = np.random.default_rng(1)
    robot = random_concentric_robot(chance, 3)
    ways = [random_concentric_configuration(chance, robot) for _ in range(20)]
    batch = solve_concentric_tube_batch(
        robot,
        np.array([one.rotations_rad for one in ways]),
        np.array([one.translations_mm for one in ways]),
        with_jacobian=True,
    )
    for row, configuration in enumerate(ways):
        alone = solve_concentric_tubes(robot, configuration)
        assert batch.patient_from_tip[row] == pytest.approx(alone.patient_from_tip, abs=1e-9)
        assert batch.tip_jacobian[row] == pytest.approx(alone.tip_jacobian, abs=1e-9)


def test_joint_values_out_of_order_have_no_solution_in_a_batch():
    robot, configuration, _ = random_case(0, 2)
    bad = ConcentricTubeConfiguration(
        configuration.rotations_rad, configuration.translations_mm - np.array([0.0, 500.0])
    )
    batch = solve_concentric_tube_batch(robot, bad.rotations_rad[None], bad.translations_mm[None])
    assert batch.status[0] == 1 and np.isnan(batch.patient_from_tip[0, :3]).all()
