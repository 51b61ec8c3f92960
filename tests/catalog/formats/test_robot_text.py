"""Orientations mean the same in each form, and files that are none are refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from catalog.formats.robot_text import Orientation, robot_kind, to_rotation
from nodes.errors import BadInput

vectors = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.01)


@given(vectors, st.floats(0.1, 100))
def test_a_direction_is_reached_the_shortest_way(direction, size):
    """The angle of the whole rotation is that between patient +z and the direction."""
    unit = np.array(direction) / np.linalg.norm(direction)
    turn = to_rotation(Orientation(direction=tuple(size * unit)), "here")
    np.testing.assert_allclose(turn[:, 2], unit, atol=1e-12)
    angle = Rotation.from_matrix(turn).magnitude()
    assert angle == pytest.approx(np.arctan2(np.hypot(*unit[:2]), unit[2]), abs=1e-7)


def test_down_is_reached_about_the_patients_y():
    turn = to_rotation(Orientation(direction=(0, 0, -2)), "here")
    np.testing.assert_allclose(turn, np.diag([-1.0, 1, -1]), atol=1e-15)


@given(vectors, st.floats(-180, 180))
def test_roll_turns_about_the_direction(direction, roll):
    plain = to_rotation(Orientation(direction=direction), "here")
    rolled = to_rotation(Orientation(direction=direction, roll_deg=roll), "here")
    own = plain.T @ rolled
    np.testing.assert_allclose(own[:, 2], [0, 0, 1], atol=1e-12)
    assert own[0, 0] == pytest.approx(np.cos(np.radians(roll)), abs=1e-12)
    assert own[1, 0] == pytest.approx(np.sin(np.radians(roll)), abs=1e-12)


@given(vectors, st.floats(0, 3))
def test_a_quaternion_turns_about_its_axis(axis, angle):
    """By the half-angle formula and Rodrigues' rotation of a vector."""
    axis = np.array(axis) / np.linalg.norm(axis)
    written = (np.cos(angle / 2), *(np.sin(angle / 2) * axis))
    turn = to_rotation(Orientation(quaternion=written), "here")
    v = np.array([0.3, -1, 2])
    expected = v * np.cos(angle) + np.cross(axis, v) * np.sin(angle)
    expected += axis * (axis @ v) * (1 - np.cos(angle))
    np.testing.assert_allclose(turn @ v, expected, atol=1e-12)


@given(vectors)
def test_a_rotation_of_few_decimals_is_mended_and_one_of_all_digits_kept(vector):
    exact = Rotation.from_rotvec(vector).as_matrix()
    kept = to_rotation(Orientation(rotation=tuple(map(tuple, exact))), "here")
    assert kept.tobytes() == exact.tobytes()
    mended = to_rotation(Orientation(rotation=tuple(map(tuple, exact.round(4)))), "here")
    np.testing.assert_allclose(mended.T @ mended, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(mended, exact, atol=2e-4)


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ({}, "no orientation"),
        ({"roll_deg": 5}, "roll_deg"),
        ({"direction": (0, 0, 1), "quaternion": (1, 0, 0, 0)}, "quaternion, direction"),
        ({"quaternion": (1, 0, 0, 0), "roll_deg": 5}, "quaternion, roll_deg"),
        ({"quaternion": (1, 1, 0, 0)}, "length 1"),
        ({"rotation": ((1, 0, 0), (0, 1, 0), (0, 0, -1))}, "right-handed"),
        ({"rotation": ((1, 0, 0), (0, 1, 0), (0, 0, 2))}, "length 1"),
    ],
)
def test_what_is_no_orientation_is_refused_with_its_place(written, told):
    with pytest.raises(BadInput, match="here") as caught:
        to_rotation(Orientation(**written), "here")
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"tubes: []\n", "the key robot is missing"),
        (b"robot: crips\n", "did you mean crisp?"),
        (b"robot: [crisp]\n", "no robot"),
        (b"robot: crisp\nrobot: crisp\n", "stands twice"),
        (b"- crisp\n", "key: value"),
        (b"\xff\xfe", "must be YAML"),
        (b"", "the key robot is missing"),
    ],
)
def test_what_is_no_robots_file_is_refused(content, told):
    with pytest.raises(BadInput) as caught:
        robot_kind(content)
    assert told in str(caught.value)
