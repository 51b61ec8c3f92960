"""Where snares grasp, and when they are too short, in cases that a ruler answers."""

from dataclasses import replace

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.mechanics.crisp_reach import find_grasps, is_too_short
from nodes.mechanics.robots import Snare
from tests.nodes.mechanics.made_robots import crisp

LENGTHS = np.array([[200.0, 105.0, 105.0], [210.0, 105.0, 105.0]])


def test_a_grasp_measured_from_the_tip_moves_with_the_tool():
    assert np.allclose(find_grasps(crisp(), LENGTHS), [[80, 120], [90, 130]])
    fixed = crisp(snares=(Snare(1, 70.0, "entry"), Snare(2, 80.0)))
    assert np.allclose(find_grasps(fixed, LENGTHS), [[70, 120], [70, 130]])


def test_joints_that_pass_one_another_are_refused():
    passing = crisp(snares=(Snare(1, 85.0, "entry"), Snare(2, 120.0)))
    with pytest.raises(BadInput, match="order"):
        find_grasps(passing, LENGTHS)


def test_grasps_off_the_tool_are_refused():
    with pytest.raises(BadInput, match="between its entry point and its tip"):
        find_grasps(crisp(), np.array([[100.0, 105.0, 105.0]]))


@pytest.mark.parametrize(
    ("lengths", "short"),
    [
        ((200.0, 105.0, 105.0), False),
        ((200.0, 48.0, 105.0), True),  # entry points 1 are 128 mm apart, the grasp is at 80 mm
        ((200.0, 49.0, 105.0), False),
        ((200.0, 105.0, 36.0), True),  # and 156 mm with the grasp at 120 mm
        ((200.0, 105.0, 37.0), False),
    ],
)
def test_needles_are_too_short_beyond_the_triangle(lengths, short):
    lengths = np.array(lengths)
    assert bool(is_too_short(crisp(), lengths, find_grasps(crisp(), lengths))) is short


def test_two_snares_must_reach_each_other_along_the_tool():
    entries = np.array([[0.0, 0, 0], [80, 0, 0], [-80, 0, 0]])
    setup = replace(crisp(), entry_points_patient_mm=entries)
    near = np.array([150.0, 60.0, 50.0])
    assert is_too_short(setup, near, np.array([70.0, 110.0])).item() is True
    assert is_too_short(setup, near, np.array([60.0, 110.0])).item() is False
