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
    enclosed_holes,
    open_planes,
    plane_holes,
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
