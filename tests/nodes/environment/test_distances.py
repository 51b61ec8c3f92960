"""Distances to faces against all boxes, scipy on a finer grid, and a ball's formula."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage

from nodes.environment.distances import distance_to_faces


def brute_force(mask, spacing):
    reach = max(mask.shape) + 1
    padded = np.pad(mask, reach)
    kinds = {kind: np.argwhere(padded == kind) - reach for kind in (False, True)}
    distance = np.full(mask.shape, np.inf)
    for place in np.ndindex(mask.shape):
        others = kinds[not mask[place]]
        gaps = np.maximum(abs(others - place) - 0.5, 0) * spacing
        distance[place] = np.linalg.norm(gaps, axis=1).min(initial=np.inf)
    return distance


@settings(max_examples=60, deadline=None)
@given(arrays(bool, st.tuples(*[st.integers(1, 5)] * 3)), st.tuples(*[st.floats(0.3, 3)] * 3))
def test_each_cell_knows_the_nearest_box_of_the_other_kind(mask, spacing):
    found = distance_to_faces(mask, np.array(spacing))
    np.testing.assert_allclose(found, brute_force(mask, np.array(spacing)), rtol=1e-6)


@pytest.mark.parametrize("share", [0.02, 0.5, 0.97])
def test_scipy_finds_the_same_on_a_grid_with_the_boxes_corners(share):
    """Boxes end at odd points of a grid twice as fine, centres are its even points."""
    mask = np.pad(np.random.default_rng(3).random((40, 23, 31)) < share, 1)
    found = distance_to_faces(mask, np.array([1.5, 1.5, 1.5]))
    for kind in (False, True):
        boxes = np.zeros(np.array(mask.shape) * 2 - 1, bool)
        boxes[::2, ::2, ::2] = mask == kind
        boxes = ndimage.binary_dilation(boxes, np.ones((3, 3, 3), bool))
        expected = ndimage.distance_transform_edt(~boxes)[::2, ::2, ::2] * 0.75
        others = mask != kind
        if kind:  # beyond the grid nothing is mask, so cells outside see the mask alone
            np.testing.assert_allclose(found[others], expected[others], rtol=1e-6)
        else:
            inner = others & ndimage.binary_erosion(np.ones_like(mask))
            np.testing.assert_allclose(found[inner], expected[inner], rtol=1e-6)


def test_nothing_to_meet_is_infinitely_far_and_the_edge_of_the_grid_ends_the_mask():
    assert np.isinf(distance_to_faces(np.zeros((3, 4, 5), bool), np.ones(3))).all()
    full = distance_to_faces(np.ones((5, 7, 9), bool), np.array([1.0, 2.0, 3.0]))
    assert full[2, 3, 4] == pytest.approx(2.5)
    assert full[0, 3, 4] == pytest.approx(0.5)


def test_a_balls_distances_are_those_of_its_formula_within_half_a_diagonal():
    index = np.stack(np.indices((60, 60, 60)), axis=-1) - 29.5
    away = np.linalg.norm(index, axis=-1)
    found = distance_to_faces(away < 20, np.ones(3))
    assert abs(found - abs(20 - away)).max() <= np.sqrt(3) / 2
