"""The k-d tree of poses against brute force in NumPy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.kernels.nearest_poses import ROWS, insert_pose, nearest_pose
from nodes.planning.tree_memory import make_poses


def draw_poses(rng, count, needles, lever=50.0, about=0.0):
    """Return (count, rows) scaled coordinates; the larger `about`, the more alike the turns."""
    quaternions = rng.normal(size=(count, needles, 4)) + np.array([about, 0.0, 0.0, 0.0])
    quaternions /= np.linalg.norm(quaternions, axis=2)[..., None]
    lengths = rng.uniform(20, 150, (count, needles, 1))
    return np.concatenate([2 * lever * quaternions, lengths], axis=2).reshape(count, -1)


def plant(points):
    poses = make_poses(6 * len(points), points.shape[1] // ROWS)
    for number, point in enumerate(points):
        insert_pose(poses, point.copy(), number)
    return poses


def distances(points, point):
    """Squared distances by the metric's definition."""
    all_poses, one = points.reshape(len(points), -1, ROWS), point.reshape(-1, ROWS)
    same = ((all_poses[..., :4] - one[:, :4]) ** 2).sum(axis=2)
    opposite = ((all_poses[..., :4] + one[:, :4]) ** 2).sum(axis=2)
    return (np.minimum(same, opposite) + (all_poses[..., 4] - one[:, 4]) ** 2).sum(axis=1)


@settings(max_examples=40)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(1, 400),
    needles=st.integers(1, 3),
    about=st.sampled_from([0.0, 2.0, 30.0]),
)
def test_nearest_is_what_brute_force_finds(seed, count, needles, about):
    rng = np.random.default_rng(seed)
    points = draw_poses(rng, count, needles, about=about)
    poses = plant(points)
    for point in draw_poses(rng, 5, needles, about=about):
        squared = distances(points, point)
        number, found = nearest_pose(poses, point)
        assert number == squared.argmin()
        assert found == pytest.approx(squared.min(), rel=1e-12)


def test_nearest_of_a_grown_walk_is_what_brute_force_finds():
    rng = np.random.default_rng(1)
    points = draw_poses(rng, 1, 2).repeat(20_000, 0)
    points += 0.05 * np.cumsum(rng.normal(size=points.shape), axis=0)
    poses = plant(points)
    for point in points[::2000] + rng.normal(size=(10, 10)):
        assert nearest_pose(poses, point)[0] == distances(points, point).argmin()


def test_quaternion_and_its_opposite_are_one_pose():
    rng = np.random.default_rng(2)
    points = draw_poses(rng, 300, 2)
    poses = plant(points)
    for number, point in enumerate(points):
        flipped = point * np.repeat(rng.choice([-1.0, 1.0], 2), ROWS)
        flipped[[4, 9]] = point[[4, 9]]
        assert nearest_pose(poses, flipped)[0] == number


def test_first_of_equal_poses_is_found_however_many_there_are():
    points = np.repeat(draw_poses(np.random.default_rng(3), 3, 1), 40, axis=0)
    poses = plant(points)
    for first in (0, 40, 80):
        assert nearest_pose(poses, points[first]) == (first, 0.0)


def test_distance_of_a_turn_is_about_the_lever_times_its_angle():
    lever, angle = 50.0, 0.2
    still = np.array([[2 * lever, 0.0, 0.0, 0.0, 70.0]])
    turned = np.array([np.cos(angle / 2), np.sin(angle / 2), 0.0, 0.0]) * 2 * lever
    _, squared = nearest_pose(plant(still), np.append(turned, 70.0))
    assert np.sqrt(squared) == pytest.approx(4 * lever * np.sin(angle / 4), rel=1e-9)
