"""Masks: parts, boxes, holes, opening and closing, held against brute force and closed forms."""

from collections import deque
from itertools import product

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nodes.geometry.masks import (
    bounding_box,
    close_mask,
    connected_parts,
    depth_mm,
    enclosed_holes,
    grow_mask,
    largest_part,
    open_planes,
    parts_of_size,
    parts_that_meet,
    plane_hole_parts,
    plane_holes,
    shrink_mask,
)

STEPS = [step for step in product((-1, 0, 1), repeat=3) if sum(map(abs, step)) == 1]
small_masks = arrays(bool, st.tuples(*[st.integers(1, 5)] * 3))
anything = settings(max_examples=40, deadline=None)


def reached(mask, starts, steps=STEPS):
    """All voxels of a mask that a walk over `steps` reaches from `starts`."""
    seen, queue = set(), deque(start for start in starts if mask[start])
    while queue:
        place = queue.popleft()
        if place in seen:
            continue
        seen.add(place)
        for step in steps:
            there = tuple(p + s for p, s in zip(place, step, strict=True))
            if all(0 <= t < n for t, n in zip(there, mask.shape, strict=True)) and mask[there]:
                queue.append(there)
    return seen


@anything
@given(small_masks)
def test_parts_are_what_a_walk_over_faces_reaches(mask):
    parts, sizes = connected_parts(mask)
    assert ((parts > 0) == mask).all() and sizes.sum() == mask.sum()
    for place in map(tuple, np.argwhere(mask)):
        part = {tuple(other) for other in np.argwhere(parts == parts[place])}
        assert part == reached(mask, [place])
        assert sizes[parts[place] - 1] == len(part)


@anything
@given(small_masks, st.integers(1, 4))
def test_parts_are_chosen_by_size_and_by_what_they_meet(mask, smallest):
    parts = [reached(mask, [place]) for place in map(tuple, np.argwhere(mask))]
    sizes = {place: len(part) for part in parts for place in part}
    other = np.random.default_rng(0).random(mask.shape) < 0.3
    large, met = parts_of_size(mask, smallest), parts_that_meet(mask, other)
    most = largest_part(mask)
    for part in parts:
        for place in part:
            assert large[place] == (sizes[place] >= smallest)
            assert met[place] == any(other[p] for p in part)
    assert not (large | met | most)[~mask].any()
    assert most.sum() == max(sizes.values(), default=0) and len(connected_parts(most)[1]) <= 1


@anything
@given(small_masks, st.floats(0.2, 4.0))
def test_growing_and_shrinking_reach_as_far_as_every_pair_of_centres_says(mask, radius):
    spacing = np.array([1.0, 0.7, 2.0])
    places = np.argwhere(np.ones_like(mask)) * spacing
    inside, outside = places[mask.ravel()], places[~mask.ravel()]

    def nearest(points):
        apart = np.linalg.norm(places[:, None] - points[None], axis=2)
        return apart.min(axis=1, initial=np.inf).reshape(mask.shape)

    if abs(np.subtract.outer([radius], nearest(inside))).min() > 1e-4:
        np.testing.assert_array_equal(grow_mask(mask, radius, spacing), nearest(inside) <= radius)
    if abs(np.subtract.outer([radius], nearest(outside))).min() > 1e-4:
        np.testing.assert_array_equal(shrink_mask(mask, radius, spacing), nearest(outside) > radius)


def test_depth_of_a_ball_is_that_of_its_radius():
    x, y, z = np.ogrid[-20:21, -20:21, -10:11]
    away = np.sqrt(x**2 + y**2 + (2.0 * z) ** 2)
    depth = depth_mm(away <= 15, np.array([1.0, 1.0, 2.0]))
    np.testing.assert_allclose(depth, 15 - away, atol=np.sqrt(6))  # a voxel's diagonal


@anything
@given(small_masks, st.integers(0, 2))
def test_every_hole_of_a_plane_has_a_number_of_its_own(mask, axis):
    parts = plane_hole_parts(mask, axis)
    np.testing.assert_array_equal(parts > 0, plane_holes(mask, axis))
    steps = [step for step in STEPS if step[axis] == 0]
    for place in map(tuple, np.argwhere(parts)):
        part = {tuple(other) for other in np.argwhere(parts == parts[place])}
        assert part == reached(~mask, [place], steps)


@anything
@given(small_masks, st.integers(0, 2))
def test_the_box_holds_the_mask_and_no_less_fits(mask, margin):
    box = bounding_box(mask, margin)
    assert mask[box].sum() == mask.sum()
    for axis, side in enumerate(box):
        places = np.argwhere(mask)[:, axis]
        if len(places):
            assert side.start == max(places.min() - margin, 0)
            assert side.stop == places.max() + 1 + margin


@anything
@given(small_masks)
def test_enclosed_holes_are_what_no_walk_from_the_edge_reaches(mask):
    edge = [p for p in np.ndindex(mask.shape)
            if any(q in (0, n - 1) for q, n in zip(p, mask.shape, strict=True))]  # fmt: skip
    outside = reached(~mask, edge)
    expected = {place for place in np.ndindex(mask.shape) if not mask[place]} - outside
    assert {tuple(place) for place in np.argwhere(enclosed_holes(mask))} == expected


@anything
@given(small_masks, st.integers(0, 2))
def test_plane_holes_are_what_no_walk_within_the_plane_reaches(mask, axis):
    others = [other for other in range(3) if other != axis]
    edge = [p for p in np.ndindex(mask.shape)
            if any(p[a] in (0, mask.shape[a] - 1) for a in others)]  # fmt: skip
    outside = reached(~mask, edge, [step for step in STEPS if step[axis] == 0])
    expected = {place for place in np.ndindex(mask.shape) if not mask[place]} - outside
    assert {tuple(place) for place in np.argwhere(plane_holes(mask, axis))} == expected


def slab_with_slit(width: int) -> np.ndarray:
    mask = np.ones((20, 30, 8), bool)
    mask[:, 14 : 14 + width] = False
    return mask


def test_closing_fills_slits_narrower_than_twice_the_radius_only():
    spacing = np.array([1.0, 0.5, 2.0])
    assert close_mask(slab_with_slit(8), 2.0, spacing)[2:-2, :, 2:-2].all()
    np.testing.assert_array_equal(close_mask(slab_with_slit(9), 2.0, spacing), slab_with_slit(9))


def test_opening_removes_plates_within_the_planes_but_not_across():
    plates = ~slab_with_slit(4)
    assert not open_planes(plates, 2, 2.5, np.array([1.0, 1.0, 1.0])).any()
    assert open_planes(plates, 1, 2.5, np.array([1.0, 1.0, 1.0])).sum() > 0.9 * plates.sum()


def test_a_radius_below_a_voxel_changes_nothing():
    mask = np.random.default_rng(0).random((6, 7, 8)) < 0.5
    spacing = np.array([1.0, 1.0, 1.0])
    np.testing.assert_array_equal(close_mask(mask, 0.9, spacing), mask)
    np.testing.assert_array_equal(open_planes(mask, 2, 0.9, spacing), mask)
