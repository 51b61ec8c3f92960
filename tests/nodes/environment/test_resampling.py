"""Masks on cubic cells: shares add up to the volume and lie where the mask lies."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from nodes.environment.resampling import resample_mask


@settings(max_examples=60, deadline=None)
@given(
    arrays(bool, st.tuples(*[st.integers(1, 6)] * 3)),
    st.tuples(*[st.floats(0.4, 3)] * 3),
    st.floats(3, 8),
    st.integers(0, 99),
)
def test_wide_cells_keep_volume_and_place_of_any_mask(mask, spacing, size, seed):
    assume(mask.any())
    axes = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = axes * np.array(spacing), (5, -6, 7)
    share, cells = resample_mask(mask, matrix, size)
    assert share.sum() * size**3 == pytest.approx(mask.sum() * np.prod(spacing), rel=1e-4)
    assert share.min() >= 0 and share.max() <= 1 + 1e-5
    before = (matrix @ [*np.argwhere(mask).mean(axis=0), 1])[:3]
    index = np.indices(share.shape).reshape(3, -1) @ share.ravel() / share.sum()
    apart = axes.T @ ((cells @ [*index, 1])[:3] - before)
    assert (abs(apart) <= size / 2 + 1e-3).all()


@settings(max_examples=30, deadline=None)
@given(arrays(bool, st.tuples(*[st.integers(1, 4)] * 3)), st.floats(0.3, 5))
def test_two_layers_around_are_empty(mask, size):
    assume(mask.any())
    share, _ = resample_mask(mask, np.diag([1.0, 2.0, 3.0, 1.0]), size)
    inner = share[2:-2, 2:-2, 2:-2].sum()
    assert inner == pytest.approx(share.sum(), rel=1e-6)


def test_narrow_cells_are_linear_between_voxel_centres():
    mask = np.zeros((1, 1, 2), bool)
    mask[0, 0, 0] = True
    share, cells = resample_mask(mask, np.diag([4.0, 4.0, 4.0, 1.0]), 1.0)
    places = (cells @ np.vstack([np.indices(share.shape).reshape(3, -1), np.ones(share.size)]))[:3]
    expected = np.clip(1 - abs(places) / 4, 0, 1).prod(axis=0)
    np.testing.assert_allclose(share.ravel(), expected, atol=1e-6)


def test_cells_of_the_voxels_own_size_reproduce_the_mask():
    mask = np.random.default_rng(0).random((5, 6, 7)) < 0.5
    share, cells = resample_mask(mask, np.diag([2.0, 2.0, 2.0, 1.0]), 2.0)
    index = np.argwhere(share > 0.5)
    places = index @ cells[:3, :3].T + cells[:3, 3]
    np.testing.assert_allclose(places, np.argwhere(mask) * 2.0, atol=1e-9)
