"""Vectors as tuples of floats: they live in registers, and their length is known when compiling."""

from numba import njit
from numba.cpython.unsafe.tuple import tuple_setitem

from nodes.kernels.ctr_options import INNER


@njit(**INNER)
def add(vector, factor, other):
    """Return vector + factor * other."""
    for i in range(len(vector)):
        vector = tuple_setitem(vector, i, vector[i] + factor * other[i])
    return vector


@njit(**INNER)
def zeros_like(vector):
    """Return a vector of that length that is 0."""
    for i in range(len(vector)):
        vector = tuple_setitem(vector, i, 0.0)
    return vector


@njit(**INNER)
def take(vector, array, row, first):
    """Return `array[row, first : first + len(vector)]` as a tuple."""
    for i in range(len(vector)):
        vector = tuple_setitem(vector, i, array[row, first + i])
    return vector


@njit(**INNER)
def put(vector, array, row, first):
    """Write a tuple to `array[row, first : first + len(vector)]`."""
    for i in range(len(vector)):
        array[row, first + i] = vector[i]


@njit(**INNER)
def prepend(value, vector):
    """Return the vector with a value before it."""
    return tuple_setitem(vector[:1] + vector, 0, value)
