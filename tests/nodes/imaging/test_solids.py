"""Solids: distances against sampled surfaces, sets against the logic of points."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree

from nodes.imaging.solids import box, cut, ellipsoid, join, scale_towards, shell, shrink, tube

AXES = [np.arange(-20, 21, dtype=np.float32) + offset for offset in (0.2, -0.3, 0.1)]
POINTS = (AXES[0][:, None, None], AXES[1][None, :, None], AXES[2][None, None, :])
PLACES = np.stack(np.meshgrid(*AXES, indexing="ij"), axis=-1).reshape(-1, 3)
EGG, BRICK = ellipsoid((1, -2, 3), (9, 14, 12)), box((4, 2, 0), (5, 6, 7))


def at_places(solid):
    return np.broadcast_to(solid.distance(POINTS), (41, 41, 41)).ravel()


def in_egg(places):
    return (((places - (1, -2, 3)) / (9, 14, 12)) ** 2).sum(axis=1) < 1


def in_brick(places):
    return (abs(places - (4, 2, 0)) < (5, 6, 7)).all(axis=1)


def sphere_directions(count: int) -> np.ndarray:
    directions = np.random.default_rng(0).normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def test_distance_to_an_ellipsoid_is_right_near_its_surface():
    surface = sphere_directions(200_000) * (9, 14, 12) + (1, -2, 3)
    true, _ = cKDTree(surface).query(PLACES, distance_upper_bound=1)
    near = true < 1
    np.testing.assert_allclose(abs(at_places(EGG)[near]), true[near], atol=0.12)
    np.testing.assert_array_equal(at_places(EGG) < 0, in_egg(PLACES))


def test_distance_to_a_tube_is_that_to_the_nearest_point_of_its_course():
    course = np.array([(-12.0, 0, 0), (0, 8, 3), (10, 8, -6)])
    dense = np.concatenate([np.linspace(a, b, 4000) for a, b in pairwise(course)])
    true, _ = cKDTree(dense).query(PLACES)
    np.testing.assert_allclose(at_places(join(tube(course, 3.0))), true - 3, atol=5e-3)


def test_a_high_tube_is_higher_than_wide_by_its_factor():
    inside = at_places(join(tube(np.array([(-30.0, 0, 0), (30, 0, 0)]), 4.0, 2.0))) < 0
    y, z = PLACES[:, 1], PLACES[:, 2]
    np.testing.assert_array_equal(inside, (y / 4) ** 2 + (z / 8) ** 2 < 1)


@pytest.mark.parametrize(
    ("solid", "inside"),
    [
        (join([EGG, BRICK]), in_egg(PLACES) | in_brick(PLACES)),
        (cut([EGG, BRICK]), in_egg(PLACES) & in_brick(PLACES)),
        (cut([EGG], [BRICK]), in_egg(PLACES) & ~in_brick(PLACES)),
        (scale_towards(BRICK, (9, 2, 0), 0.5), in_brick((PLACES - (9, 2, 0)) * 2 + (9, 2, 0))),
    ],
)
def test_sets_of_solids_hold_the_points_that_logic_says(solid, inside):
    np.testing.assert_array_equal(at_places(solid) < 0, inside)


def test_shell_and_core_lie_around_and_under_the_surface():
    ball = ellipsoid((0, 0, 0), (12, 12, 12))
    radius = np.linalg.norm(PLACES, axis=1)
    np.testing.assert_array_equal(at_places(shell(ball, 2)) < 0, abs(radius - 12) < 2)
    np.testing.assert_array_equal(at_places(shrink(ball, 3)) < 0, radius < 9)


BENT = join(tube(np.array([(-9.0, 0, 0), (3, 8, 3)]), 3.0, 2.0))
SOME = [EGG, BRICK, cut([EGG, BRICK]), join([EGG, BRICK]), shell(EGG, 2),
        scale_towards(EGG, (9, 2, 0), 0.5), BENT]  # fmt: skip


@pytest.mark.parametrize("solid", SOME)
def test_the_box_of_a_solid_holds_all_of_it(solid):
    inside = PLACES[at_places(solid) < 0]
    assert len(inside) > 100
    assert (inside >= solid.low).all() and (inside <= solid.high).all()
