"""Clearances of segments against dense sampling; needles in a slab against closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.kernels.needle_rays import (
    FORBIDDEN,
    FREE,
    OUTSIDE,
    WALL,
    NeedleRules,
    segment_clearance,
    trace_needles,
)


@pytest.mark.parametrize(
    "call", [segment_clearance, segment_clearance.py_func], ids=["compiled", "python"]
)
@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_clearance_is_the_least_over_the_segment_and_all_boxes(call, seed):
    rng = np.random.default_rng(seed)
    start, end = rng.uniform(-5, 5, (2, 3))
    boxes, half = rng.uniform(-8, 8, (12, 3)), rng.uniform(0.1, 1.5, 3)
    places = start + np.linspace(0, 1, 4001)[:, None] * (end - start)
    away = np.maximum(abs(places[:, None] - boxes) - half, 0)
    dense = np.linalg.norm(away, axis=2).min()
    exact = call(start, end, boxes, half)
    assert dense - np.linalg.norm(end - start) / 8000 - 1e-9 <= exact <= dense + 1e-6


def test_no_box_leaves_the_clearance_infinite():
    none = segment_clearance(np.zeros(3), np.ones(3), np.empty((0, 3)), np.ones(3))
    assert none == np.inf


def slab(bone_at=None, spacing=(0.5, 0.7, 1.0)):
    """Air for 10 mm of x, then 14 mm of wall, then free space."""
    kinds = np.full((80, 40, 30), FREE, np.uint8)
    kinds[:20], kinds[20:48] = OUTSIDE, WALL
    if bone_at:
        kinds[bone_at] = FORBIDDEN
    bone = np.argwhere(kinds == FORBIDDEN) * spacing
    centres = np.argwhere(np.ones(kinds.shape, bool)) * np.array(spacing)
    distance = np.full(kinds.shape, np.inf, np.float32)
    if len(bone):
        away = np.maximum(abs(centres[:, None] - bone) - np.array(spacing) / 2, 0)
        distance = np.linalg.norm(away, axis=2).min(axis=1).reshape(kinds.shape)
    return kinds, distance.astype(np.float32), np.array(spacing)


def trace(space, start, direction, clearance=1.0, thickest=30.0, depth=2.0):
    kinds, distance, spacing = space
    direction = np.asarray(direction, float) / np.linalg.norm(direction)
    found, nearest = np.empty((1, 1, 2)), np.empty((1, 1))
    rules = NeedleRules(clearance, thickest, depth, 0.1, 30.0)
    trace_needles(np.asarray(start, float).reshape(1, 1, 3), direction.reshape(1, 1, 3), kinds,
                  distance, spacing, rules, found, nearest)  # fmt: skip
    return found[0, 0]


@pytest.mark.parametrize("tilt", [0.0, 0.4, -0.4])
def test_ways_to_skin_and_free_space_are_those_of_a_slab(tilt):
    skin, pleura = trace(slab(), (2.0, 13.0, 15.0), (1.0, tilt, 0.0))
    slope = np.sqrt(1 + tilt**2)
    assert skin == pytest.approx(7.75 * slope, abs=0.11)
    assert pleura == pytest.approx(21.75 * slope, abs=0.11)


def test_needles_are_refused_one_reason_at_a_time():
    start, straight = (2.0, 13.0, 15.0), (1.0, 0.0, 0.0)
    assert not np.isnan(trace(slab(), start, straight)[1])
    assert np.isnan(trace(slab(), start, straight, thickest=13.0)[1])
    assert np.isnan(trace(slab(), start, straight, depth=20.0)[1])
    assert np.isnan(trace(slab(), start, (-1.0, 0.0, 0.0))[1])
    begins_in_the_wall = (12.0, 13.0, 15.0)
    assert np.isnan(trace(slab(), begins_in_the_wall, straight)[1])


@pytest.mark.parametrize(("clearance", "passes"), [(2.2, True), (2.6, False)])
def test_bone_beside_the_needle_counts_from_its_side_of_the_box(clearance, passes):
    """The box begins at y = 15.05, so the axis at y = 12.6 passes it at 2.45 mm."""
    space = slab((slice(30, 32), slice(22, 24), slice(14, 17)))
    found = trace(space, (2.0, 12.6, 15.0), (1.0, 0.0, 0.0), clearance)
    assert (not np.isnan(found[1])) == passes
