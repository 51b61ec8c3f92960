import numpy as np
import pytest

from nodes.geometry.meshes import Surfaces
from nodes.geometry.origin import Origin
from nodes.reporting.camera_pictures import (
    GOAL,
    TISSUES,
    WALL,
    draw_view,
    gather_tissues,
    is_in_view,
    place_goals,
)
from tests.nodes.reporting import made_plans
from tests.nodes.reporting.conftest import make_sphere

AHEAD = np.array([[0.0, 0, 30]])


@pytest.fixture(scope="module")
def distance():
    return made_plans.make_distance()


def look(distance, surfaces=(), goals=AHEAD, turn=None, at=(0.0, 0, 0), angle=90.0, pixels=64):
    pose = np.eye(4)
    pose[:3, :3] = np.eye(3) if turn is None else turn
    pose[:3, 3] = at
    tissues = gather_tissues(Surfaces(tuple(surfaces), Origin("test")), 3.0)
    return draw_view(distance, tissues, pose, angle, goals, pixels, 30.0).astype(int)


def is_goal(picture):
    return np.abs(picture - GOAL).max(axis=2) < 5


def test_the_picture_is_a_lit_circle_on_black(distance):
    picture = look(distance, goals=np.zeros((0, 3)))
    middle = (2 * np.arange(64) + 1) / 64 - 1
    radius = np.hypot(*np.meshgrid(middle, middle))
    assert (picture[radius > 1.03] == 0).all()
    assert (picture[radius < 0.97].max(axis=1) > 20).all()


def test_a_goal_ahead_is_ringed_in_the_middle_and_one_behind_nowhere(distance):
    rows, columns = np.nonzero(is_goal(look(distance)))
    assert (rows.mean(), columns.mean()) == pytest.approx((31.5, 31.5), abs=0.5)
    assert not is_goal(look(distance, goals=-AHEAD)).any()


def test_right_and_down_in_the_picture_are_the_cameras_x_and_y(distance):
    right, down = (np.array([[10.0, 0, 30]]), np.array([[0.0, 10, 30]]))
    assert np.nonzero(is_goal(look(distance, goals=right)))[1].mean() > 38
    assert np.nonzero(is_goal(look(distance, goals=down)))[0].mean() > 38


def test_angles_grow_evenly_to_half_the_field_of_view():
    angles = np.radians([0.0, 15, 30, 45, 60])
    points = 50 * np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=1)
    places = place_goals(np.eye(4), 90.0, points)
    assert places[:, 0] == pytest.approx(np.degrees(angles) / 45, abs=1e-9)
    assert is_in_view(np.eye(4), 90.0, points).tolist() == [True, True, True, True, False]


def test_the_wall_nearer_to_the_lamp_is_brighter(distance):
    """The camera moves to the left end and looks along +y: what is left of x is nearer."""
    turn = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    picture = look(distance, turn=turn, at=(-25.0, 0, 0), goals=np.zeros((0, 3)), angle=120.0)
    light = picture.sum(axis=2)
    assert light[28:36, 8:20].mean() > 1.3 * light[28:36, 48:60].mean()


def test_a_lung_behind_the_wall_gives_its_colour_and_elsewhere_is_the_chest(distance):
    ahead = make_sphere((0, 0, 34), 12)
    plain, lung = look(distance), look(distance, [("left_lung", ahead)])
    centre = (slice(20, 26), slice(29, 35))

    def ratio(picture):
        return picture[centre][..., 1].mean() / picture[centre][..., 2].mean()

    assert ratio(plain) == pytest.approx(WALL[1] / WALL[2], rel=0.05)
    assert ratio(lung) == pytest.approx(TISSUES["left_lung"][1] / TISSUES["left_lung"][2], rel=0.05)


def test_a_camera_within_the_wall_sees_nothing_and_does_not_fail(distance):
    picture = look(distance, at=(0.0, 0, 60.0), goals=np.zeros((0, 3)))
    assert not picture.any()
