"""Vectors in space whose three components are lanes."""

from numba import njit

from nodes.kernels.crisp_lanes import load, spread, store


@njit(cache=True, nogil=True, error_model="numpy")
def load_vector(array, row):
    """Return rows `row` to `row` + 2 of an array (rows, LANES)."""
    return load(array, row), load(array, row + 1), load(array, row + 2)


@njit(cache=True, nogil=True, error_model="numpy")
def store_vector(array, row, a):
    """Write a vector to rows `row` to `row` + 2."""
    store(array, row, a[0])
    store(array, row + 1, a[1])
    store(array, row + 2, a[2])


@njit(cache=True, nogil=True, error_model="numpy")
def axis_vector(axis):
    """Return the unit vector along axis 0, 1 or 2; for any other, zeros."""
    return (
        spread(1.0 if axis == 0 else 0.0),
        spread(1.0 if axis == 1 else 0.0),
        spread(1.0 if axis == 2 else 0.0),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def add(a, b):
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(cache=True, nogil=True, error_model="numpy")
def subtract(a, b):
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(cache=True, nogil=True, error_model="numpy")
def scale(a, factor):
    """Return a times lanes or a float."""
    return a[0] * factor, a[1] * factor, a[2] * factor


@njit(cache=True, nogil=True, error_model="numpy")
def dot(a, b):
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True, error_model="numpy")
def cross(a, b):
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, nogil=True, error_model="numpy")
def add_cross(c, a, b):
    """Return c + a x b."""
    return (
        c[0] + a[1] * b[2] - a[2] * b[1],
        c[1] + a[2] * b[0] - a[0] * b[2],
        c[2] + a[0] * b[1] - a[1] * b[0],
    )
