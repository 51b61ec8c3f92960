"""Closing by distances against closing by a moving ball."""

import numpy as np
import pytest
from scipy import ndimage

from nodes.imaging.cubic_masks import close_widely


@pytest.mark.parametrize(("radius", "size"), [(3.0, 1.0), (5.0, 2.0)])
def test_it_adds_what_no_ball_from_outside_reaches(radius, size):
    chance = np.random.default_rng(7)
    mask = ndimage.binary_dilation(chance.random((24, 20, 18)) < 0.004, iterations=2)
    reach = int(radius / size)
    offsets = np.indices((2 * reach + 1,) * 3) - reach
    ball = np.linalg.norm(offsets, axis=0) * size <= radius
    padded = np.pad(mask, reach + 1)
    expected = ndimage.binary_erosion(ndimage.binary_dilation(padded, ball), ball)
    inner = slice(reach + 1, -reach - 1)
    closed = close_widely(mask, radius, size)
    np.testing.assert_array_equal(closed, expected[inner, inner, inner] | mask)
    assert closed.sum() > mask.sum()
