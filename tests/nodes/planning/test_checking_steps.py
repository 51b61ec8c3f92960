"""Motions are cut evenly and keep to what their setup allows."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm, logm
from scipy.spatial.transform import Rotation

from nodes.planning.checking_steps import (
    check_joint_steps,
    check_limits,
    check_start,
    cut_finely,
    find_nonsense,
    joint_ways,
    least_at_steps,
    say_where,
)
from tests.nodes.planning.made_motions import PARAMETERS, PLACED, SETUP, START, move, turned

MOTION = move(tool=(10, 0, 5), snare=(0, 8, 0), longer=(4, 2), steps=3)


def test_between_steps_needles_turn_at_constant_speed_and_lengths_change_evenly() -> None:
    fine = cut_finely(MOTION, 4)
    assert fine.at.tolist() == [0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2]
    for needle in range(2):
        one, other = MOTION.orientations[1:, needle]
        for part in range(5):
            wanted = one @ expm(part / 4 * logm(one.T @ other))
            assert fine.orientations[4 + part, needle] == pytest.approx(wanted.real, abs=1e-9)
    assert fine.lengths_mm[:, 0] == pytest.approx(np.linspace(70, 74, 9))


def test_a_single_step_is_not_cut() -> None:
    fine = cut_finely(move(steps=1), 10)
    assert fine.at.tolist() == [0] and fine.lengths_mm.shape == (1, 2)


@settings(max_examples=30, deadline=None)
@given(st.floats(0, 3), st.integers(0, 1))
def test_ways_of_joints_are_angles_times_the_lever_and_shifts(angle, needle) -> None:
    turns = [np.zeros(3), np.zeros(3)]
    turns[needle] = np.degrees(angle) * np.array([0, 0.6, 0.8])
    fine = cut_finely(MOTION, 1)._replace(
        at=np.arange(2.0), orientations=np.array([turned((0, 0, 0), (0, 0, 0)), turned(*turns)]),
        lengths_mm=np.array([[70.0, 60], [70.5, 59]]),
    )  # fmt: skip
    assert joint_ways(fine, 100.0) == pytest.approx([100 * angle + 1.5], abs=1e-5)


def test_the_start_and_limits_of_a_good_motion_are_kept() -> None:
    assert find_nonsense(MOTION, SETUP) == []
    assert check_start(MOTION, PLACED) == []
    assert check_limits(cut_finely(MOTION, 3), PLACED) == []


def test_tilts_count_from_the_axis_and_not_from_the_start() -> None:
    axis = Rotation.from_rotvec(np.radians([-3, 0, 0])).as_matrix() @ [0, 0, 1]
    placed = replace(PLACED, axes=np.array([axis, START.patient_from_entry[1, :, 2]]),
                     largest_tilts_rad=np.radians([12.5, 9]))  # fmt: skip
    (told,) = check_limits(cut_finely(MOTION, 2), placed)
    # 10 degrees about x and 5 about z, of which the second leaves +z alone, after 3 to the axis.
    way = MOTION.orientations[2, 0, :, 2]
    tilt = np.degrees(np.arccos(way @ axis))
    assert f"at step 2 the tool tilts by {tilt:.4g} degrees; at most 12.5" in told


def test_steps_of_joints_are_told_with_the_needle_and_the_step() -> None:
    failures, figures = check_joint_steps(MOTION, PARAMETERS)
    turn = np.degrees(Rotation.from_rotvec(np.radians([5, 0, 2.5])).magnitude())
    assert failures[0].startswith(
        f"from step 1 to step 2 the tool turns by {turn:.4g} degrees"
    ) or (failures[0].startswith(f"from step 0 to step 1 the tool turns by {turn:.4g} degrees"))
    assert figures[0].value == pytest.approx(turn) and figures[1].value == pytest.approx(2.0)


def test_values_go_to_the_nearest_step_and_steps_without_one_are_missing() -> None:
    fine = cut_finely(move(steps=4), 2)
    found = least_at_steps(np.array([5.0, 3, 4, 1]), np.array([0.0, 0.4, 0.6, 1.4]), fine)
    np.testing.assert_array_equal(found, [3, 1, np.nan, np.nan])


def test_places_along_a_motion_are_said_in_steps() -> None:
    assert say_where(3.0) == "at step 3"
    assert say_where(3.2) == "between steps 3 and 4"
