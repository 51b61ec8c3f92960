"""Numbers that mean nothing are refused with what was found and what is allowed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nodes.errors import BadInput
from nodes.mechanics.check_numbers import (
    check_counts,
    check_finite,
    check_inside,
    check_limits,
    check_pose,
    check_range,
    check_rotation,
)

quaternions = st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(
    lambda q: np.dot(q, q) > 0.1
)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, -1.0, 6.0])
def test_what_is_out_of_range_or_no_number_is_refused_with_it(value):
    with pytest.raises(BadInput, match=f"depth = {value:g} mm"):
        check_range("depth", value, "mm", 0.0, 5.0)


def test_ends_belong_to_a_range_and_not_to_its_inside():
    check_range("depth", 0.0, "mm", 0.0, 5.0)
    check_range("depth", 5.0, "mm", 0.0, 5.0)
    check_inside("depth", 4.9, "mm", 0.0, 5.0)
    for value in (0.0, 5.0):
        with pytest.raises(BadInput, match="between 0 and 5"):
            check_inside("depth", value, "mm", 0.0, 5.0)


@given(quaternions)
def test_rotations_pass(quaternion):
    check_rotation("axes", Rotation.from_quat(quaternion).as_matrix())


@given(quaternions, st.integers(0, 8), st.sampled_from([1e-6, -1e-3, 1.0, np.nan]))
def test_a_rotation_with_one_wrong_number_is_refused(quaternion, place, error):
    wrong = Rotation.from_quat(quaternion).as_matrix().ravel()
    # An error along a number near 0 changes lengths in second order only.
    wrong[place] += np.copysign(error, wrong[place]) if abs(wrong[place]) > 0.01 else 1.0
    with pytest.raises(BadInput, match="axes"):
        check_rotation("axes", wrong.reshape(3, 3))


def test_mirrored_axes_are_refused():
    with pytest.raises(BadInput, match="mirrored"):
        check_rotation("axes", np.diag([1.0, 1, -1]))


def test_a_pose_ends_with_0_0_0_1():
    wrong = np.eye(4)
    wrong[3, 0] = 1
    with pytest.raises(BadInput, match="last line"):
        check_pose("base", wrong)


def test_rows_say_one_thing_a_tube():
    check_counts({"tubes": 2, "rotations": 2})
    with pytest.raises(BadInput, match="rotations: 3"):
        check_counts({"tubes": 2, "rotations": 3})


def test_infinite_numbers_in_rows_are_refused():
    with pytest.raises(BadInput, match="force"):
        check_finite("force", np.array([0.0, np.inf, 1]))


@pytest.mark.parametrize("limits", [[[1.0, 0]], [[np.nan, 0]], [[0.0, 1], [0, 1]]])
def test_limits_in_the_wrong_order_or_number_are_refused(limits):
    check_limits("limits", None, 1)
    check_limits("limits", np.array([[-np.inf, 0.0]]), 1)
    with pytest.raises(BadInput, match="limits"):
        check_limits("limits", np.array(limits), 1)
