"""Inverses of matrices in lanes against NumPy's."""

import numpy as np

from nodes.kernels.crisp_lanes import LANES, make_lanes
from nodes.kernels.crisp_straight_inverse import invert_lanes


def test_matrices_of_wanted_lanes_are_inverted_also_where_pivots_vanish():
    rng = np.random.default_rng(0)
    matrices, inverses, wanted = make_lanes(36), make_lanes(36), np.ones(LANES)
    matrices[:] = rng.normal(size=matrices.shape)
    matrices[0], matrices[7, 2] = 0.0, 0.0
    wanted[5] = 0.0
    signs = np.zeros(LANES)
    invert_lanes(matrices, wanted, inverses, signs, np.empty((6, 12)))
    slow = np.linalg.inv(matrices.T.reshape(LANES, 6, 6))
    fast = inverses.T.reshape(LANES, 6, 6)
    assert not fast[5].any()
    others = np.delete(np.arange(LANES), 5)
    assert np.abs(fast[others] - slow[others]).max() < 1e-10 * np.abs(slow).max()
    assert np.array_equal(signs[others], np.linalg.slogdet(slow)[0][others])
    assert {-1.0, 1.0} == set(signs[others])


def test_a_singular_matrix_gives_no_number_and_no_exception():
    inverses = make_lanes(36)
    invert_lanes(make_lanes(36), np.ones(LANES), inverses, np.zeros(LANES), np.empty((6, 12)))
    assert not np.isfinite(inverses).any()
