"""Solids: distances against sampled surfaces, painted volumes against closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree

from nodes.imaging.solids import Canvas, box, ellipsoid, paint, shell, tube

AXES = [np.arange(-20, 21, dtype=np.float32) + offset for offset in (0.2, -0.3, 0.1)]
POINTS = (AXES[0][:, None, None], AXES[1][None, :, None], AXES[2][None, None, :])
PLACES = np.stack(np.meshgrid(*AXES, indexing="ij"), axis=-1).reshape(-1, 3)


def sphere_directions(count: int) -> np.ndarray:
    directions = np.random.default_rng(0).normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def test_distance_to_an_ellipsoid_is_right_near_its_surface():
    radii, centre = np.array([9.0, 14.0, 12.0]), np.array([1.0, -2.0, 3.0])
    surface = sphere_directions(200_000) * radii + centre
    true, _ = cKDTree(surface).query(PLACES, distance_upper_bound=1)
    found = np.broadcast_to(ellipsoid(POINTS, tuple(centre), tuple(radii)), (41, 41, 41)).ravel()
    near = true < 1
    np.testing.assert_allclose(abs(found[near]), true[near], atol=0.12)
    inside = (((PLACES - centre) / radii) ** 2).sum(axis=1) < 1
    np.testing.assert_array_equal(found < 0, inside)


def test_distance_to_a_tube_is_that_to_the_nearest_point_of_its_course():
    course = np.array([(-12.0, 0, 0), (0, 8, 3), (10, 8, -6)])
    dense = np.concatenate([np.linspace(a, b, 4000) for a, b in pairwise(course)])
    true, _ = cKDTree(dense).query(PLACES)
    distance, part = tube(POINTS, course, radius=3.0, reach=2.0)
    whole = np.full((41, 41, 41), np.inf)
    whole[part] = distance
    near = true < 4.9
    np.testing.assert_allclose(whole.ravel()[near], true[near] - 3, atol=5e-3)
    assert (whole.ravel()[true > 5.1] > 1.9).all()


@pytest.mark.parametrize(
    ("solid", "volume"),
    [
        (ellipsoid(POINTS, (0, 0, 0), (9, 14, 12)), 4 / 3 * np.pi * 9 * 14 * 12),
        (box(POINTS, (1, 2, 3), (5, 6, 7)), 8 * 5 * 6 * 7),
        (shell(ellipsoid(POINTS, (0, 0, 0), (12, 12, 12)), 2), 4 / 3 * np.pi * (14**3 - 10**3)),
    ],
)
def test_painted_shares_add_up_to_the_volume(solid, volume):
    shape = (41, 41, 41)
    canvas = Canvas(POINTS, np.zeros(shape, np.float32), np.zeros(shape, np.uint8), 1.0)
    paint(canvas, solid, 100.0, 7)
    assert canvas.hu.sum() / 100 == pytest.approx(volume, rel=0.02)
    assert (canvas.labels == 7).sum() == pytest.approx(volume, rel=0.03)
    np.testing.assert_array_equal(canvas.hu > 50, canvas.labels == 7)
