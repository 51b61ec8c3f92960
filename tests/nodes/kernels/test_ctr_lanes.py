"""Arithmetic in lanes against NumPy's on the same numbers."""

import numpy as np
from numba import njit

from nodes.kernels.ctr_lanes import (
    LANES,
    choose_less,
    count_up,
    is_any_less,
    load_rows,
    make_rooms,
    make_steps,
    nearest,
    spread,
    spread_rows,
    store_points,
    store_rows,
)


@njit
def calculate(a, out):
    x, y = load_rows((0.0, 0.0), a, 0)
    z = x
    z += y
    z -= 3.0 * x
    store_rows((x + y, x - 2.0 * y, (3 + x) * y, 1.0 / x + y / 7, -x), out, 0)
    store_rows((choose_less(x, y, x, spread(0.5)), nearest(x), count_up(4.0), z), out, 5)
    store_rows(spread_rows((0.0, 0.0), 2.5), out, 9)
    return is_any_less(x, y), is_any_less(x, x)


@njit
def interleave(a, points):
    x, y, z = load_rows((0.0, 0.0, 0.0), a, 0)
    store_points(x, y, z, points, 2)


def test_lanes_calculate_as_numpy_does():
    a, out = make_steps(2), make_steps(11)
    a[:] = np.random.default_rng(1).normal(size=(2, LANES)) * 3
    x, y = a
    assert calculate(a, out) == (True, False)
    wanted = [x + y, x - 2 * y, (3 + x) * y, 1 / x + y / 7, -x, np.where(x < y, x, 0.5)]
    wanted += [np.rint(x), 4.0 + np.arange(LANES), y - 2 * x, *np.full((2, LANES), 2.5)]
    np.testing.assert_allclose(out, wanted, rtol=1e-14, atol=1e-14)


def test_what_is_not_a_number_is_less_than_nothing():
    a, out = make_steps(2), make_steps(11)
    a[0], a[1] = np.nan, 1.0
    assert calculate(a, out) == (False, False)
    assert np.isnan(out[0]).all() and (out[5] == 0.5).all()


def test_points_are_written_side_by_side():
    a, points = make_steps(3), np.zeros((LANES + 4, 3))
    a[:] = np.arange(3 * LANES).reshape(3, LANES)
    interleave(a, points)
    assert (points[2:-2] == a.T).all() and not points[:2].any() and not points[-2:].any()


def test_rooms_do_not_overlap_and_begin_with_a_line_of_their_own():
    rooms = make_rooms((5, 3), (1000,), (2, 8))
    for value, room in enumerate(rooms):
        room[:] = value
    assert all((room == value).all() for value, room in enumerate(rooms))
    places = [room.ctypes.data % 4096 for room in rooms]
    assert len(set(places)) == 3 and all(place % 64 == 0 for place in places)
