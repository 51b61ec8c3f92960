"""Vectors as tuples of floats: they live in registers, and their length is known when compiling."""

from numba import njit
from numba.extending import intrinsic

from nodes.kernels.ctr_options import INNER


@intrinsic
def replace(typing_context, vector, index, value):
    """Return the vector with another value at an index, which is not checked."""

    def generate(context, builder, signature, arguments):
        vector, index, value = arguments
        with builder.goto_entry_block():
            place = builder.alloca(vector.type)
        builder.store(vector, place)
        builder.store(value, builder.gep(place, [index.type(0), index], inbounds=True))
        return builder.load(place)

    return vector(vector, index, vector.dtype), generate


@njit(**INNER)
def add(vector, factor, other):
    """Return vector + factor * other."""
    for i in range(len(vector)):
        vector = replace(vector, i, vector[i] + factor * other[i])
    return vector


@njit(**INNER)
def zeros_like(vector):
    """Return a vector of that length that is 0."""
    for i in range(len(vector)):
        vector = replace(vector, i, 0.0)
    return vector


@njit(**INNER)
def take(vector, array, row, first):
    """Return `array[row, first : first + len(vector)]` as a tuple."""
    for i in range(len(vector)):
        vector = replace(vector, i, array[row, first + i])
    return vector


@njit(**INNER)
def put(vector, array, row, first):
    """Write a tuple to `array[row, first : first + len(vector)]`."""
    for i in range(len(vector)):
        array[row, first + i] = vector[i]


@njit(**INNER)
def prepend(value, vector):
    """Return the vector with a value before it."""
    return replace(vector[:1] + vector, 0, value)
