"""Snares that grasp nothing, twice, or at no angle are refused."""

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.mechanics.check_setups import check_entries_apart, check_joint, check_snares


@pytest.mark.parametrize(
    ("joint", "cosine", "grasp", "told"),
    [
        ("relaxed", 1.0, 10.0, "cosine = 1"),
        ("relaxed", -1.2, 10.0, "cosine = -1.2"),
        ("rigid", 0.1, 10.0, "right angles"),
        ("relaxed", 0.0, -1.0, "grasp_mm = -1 mm"),
        ("rigid", 0.0, np.nan, "grasp_mm = nan"),
    ],
)
def test_joints_that_cannot_be_are_refused(joint, cosine, grasp, told):
    with pytest.raises(BadInput, match=told):
        check_joint(joint, cosine, grasp)


def test_joints_that_can_be_pass():
    check_joint("rigid", 0.0, 0.0)
    check_joint("relaxed", -0.99, 10.0)


@pytest.mark.parametrize(
    ("grasping", "needles", "told"),
    [
        ((), 0, "no needles"),
        ((0,), 1, "needle 0 grasps 1 times"),
        ((1, 1), 2, "needle 1 grasps 2 times"),
        ((1,), 3, "needle 2 grasps 0 times"),
        ((1, 2), 2, "needle 2 grasps 1 times"),
        ((-1,), 2, "needle -1 grasps"),
    ],
)
def test_needles_grasp_once(grasping, needles, told):
    with pytest.raises(BadInput, match=told):
        check_snares(grasping, needles)


def test_snares_stand_in_any_order():
    check_snares((2, 1, 3), 4)
    check_snares((), 1)


def test_needles_enter_beside_each_other():
    points = np.array([[0.0, 0, 0], [0, 0, 1.2]])
    check_entries_apart(points, (0.6, 0.6))
    with pytest.raises(BadInput, match=r"needles 0 and 1, of radii 0.6 and 0.7 mm, enter 1.2 mm"):
        check_entries_apart(points, (0.6, 0.7))
