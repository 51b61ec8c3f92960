"""Boxes drawn into a map of directions: no direction into a box is ever missed."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from nodes.kernels.direction_maps import (
    COARSE_SIDE,
    FACES,
    FINE_SIDE,
    draw_box,
    is_box_drawn,
    is_drawn,
)


@njit
def draw(fine, coarse, way, halves):
    draw_box(fine, coarse, (way[0], way[1], way[2]), (halves[0], halves[1], halves[2]))


@njit
def are_drawn(fine, ways):
    return np.array([is_drawn(fine, (way[0], way[1], way[2])) for way in ways])


@njit
def is_any_drawn(coarse, way, halves):
    return is_box_drawn(coarse, (way[0], way[1], way[2]), (halves[0], halves[1], halves[2]))


def empty():
    fine = np.zeros((FACES, FINE_SIDE, FINE_SIDE), np.bool_)
    return fine, np.zeros((FACES, COARSE_SIDE, COARSE_SIDE), np.bool_)


@settings(max_examples=100)
@given(st.integers(0, 2**31), st.sampled_from([0.5, 3.0, 30.0]))
def test_every_direction_into_a_drawn_box_is_found(seed, distance):
    rng = np.random.default_rng(seed)
    way, halves = rng.normal(size=3) * distance, rng.uniform(0, 1.5, 3)
    if seed % 3 == 0:
        way, halves = np.round(way), np.round(halves)
    fine, coarse = empty()
    draw(fine, coarse, way, halves)
    corners = np.array(np.meshgrid(*[[-1, 0, 1]] * 3)).reshape(3, -1).T
    inside = way + halves * np.concatenate([corners, rng.uniform(-1, 1, (40, 3))])
    inside = inside[np.abs(inside).max(axis=1) > 1e-6] * rng.uniform(0.1, 9)
    assert are_drawn(fine, inside).all()
    around = inside[rng.integers(len(inside))]
    assert is_any_drawn(coarse, around, rng.uniform(0, 2, 3))


def test_far_directions_are_not_drawn():
    fine, coarse = empty()
    draw(fine, coarse, np.array([20.0, 3.0, -4.0]), np.array([0.5, 0.5, 0.5]))
    ways = np.random.default_rng(0).normal(size=(4000, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    angles = np.degrees(np.arccos(ways @ [20, 3, -4] / np.sqrt(425)))
    assert not are_drawn(fine, ways[angles > 5]).any()
    assert not is_any_drawn(coarse, np.array([-20.0, 0, 0]), np.ones(3))
    assert not is_any_drawn(coarse, np.array([0.0, 20.0, 0]), np.ones(3))
