"""Arithmetic in lanes against NumPy's on the same numbers."""

import numpy as np
import pytest
from numba import njit

from nodes.kernels.crisp_lanes import (
    LANES,
    absolute,
    choose,
    is_any,
    is_less,
    load,
    make_lanes,
    spread,
    store,
)


@njit(cache=True)
def calculate(a, out):
    x, y = load(a, 0), load(a, 1)
    store(out, 0, x + y)
    store(out, 1, x - 2.0 * y)
    store(out, 2, (3 + x) * y)
    store(out, 3, 1.0 / x + y / 7)
    store(out, 4, absolute(x))
    store(out, 5, is_less(x, y))
    store(out, 6, choose(is_less(x, y), x, spread(0.5)))
    return is_any(is_less(x, spread(-1e9)))


def test_lanes_calculate_as_numpy_does():
    a, out = make_lanes(2), make_lanes(7)
    a[:] = np.random.default_rng(0).normal(size=(2, LANES))
    x, y = a
    assert not calculate(a, out)
    wanted = [x + y, x - 2 * y, (3 + x) * y, 1 / x + y / 7, abs(x), x < y, np.where(x < y, x, 0.5)]
    assert np.abs(out - np.array(wanted)).max() < 1e-14 * np.abs(out).max()


def test_what_is_not_a_number_stays_so_and_is_less_than_nothing():
    a, out = make_lanes(2), make_lanes(7)
    a[:] = 1.0
    a[0, 3] = np.nan
    calculate(a, out)
    assert list(np.flatnonzero(np.isnan(out[0]))) == [3]
    assert np.isnan(out[4, 3]) and out[5, 3] == 0 and out[6, 3] == 0.5


def test_one_lane_is_enough_to_be_any():
    a, out = make_lanes(2), make_lanes(7)
    a[0, LANES - 1] = -1e10
    assert calculate(a, out)


@pytest.mark.parametrize("shape", [(1,), (3, 5), (2, 7, 1)])
def test_rows_begin_where_cache_lines_do(shape):
    lanes = make_lanes(*shape)
    assert lanes.shape == (*shape, LANES) and not lanes.any()
    assert lanes.ctypes.data % 64 == 0
