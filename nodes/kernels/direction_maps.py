"""A map of all directions from a point: which of them lead through what has been drawn into it.

The map is a cube around the point; its faces are cut into squares. What is drawn is a box, and all
squares are marked through which a ray to a place in the box may go, never less.
"""

import numpy as np
from numba import njit

from nodes.kernels.crisp_options import INNER

FACES = 6  # axis, and 3 more towards smaller indices
FINE_SIDE, COARSE_SIDE = 128, 16  # squares along a face's side; by trying
TOO_NEAR = 1e-3  # share of the box's size; nearer boxes may be in any direction
ROUNDING = 1e-9


@njit(**INNER)
def draw_box(fine, coarse, way, halves):
    """Mark the directions to a box whose middle is at `way` and whose sides are twice `halves`."""
    for face in range(FACES):
        left, right, low, high = _outline(face, way, halves)
        if left <= right and low <= high:
            _fill(fine[face], left, right, low, high)
            _fill(coarse[face], left, right, low, high)


@njit(**INNER)
def is_box_drawn(coarse, way, halves):
    """Return whether a direction to a box may be marked."""
    for face in range(FACES):
        left, right, low, high = _outline(face, way, halves)
        if left > right or low > high:
            continue
        side = len(coarse[face])
        for row in range(_square(left, side), _square(right, side) + 1):
            for column in range(_square(low, side), _square(high, side) + 1):
                if coarse[face, row, column]:
                    return True
    return False


@njit(**INNER)
def is_drawn(fine, way):
    """Return whether the direction of a way is marked."""
    x, y, z = abs(way[0]), abs(way[1]), abs(way[2])
    axis = 0 if (x >= y and x >= z) else (1 if y >= z else 2)
    far = max(x, y, z)
    face = axis if way[axis] > 0 else axis + 3
    side = fine.shape[1]
    row, column = way[(axis + 1) % 3] / far, way[(axis + 2) % 3] / far
    return fine[face, _square(row, side), _square(column, side)]


@njit(**INNER)
def _outline(face, way, halves):
    """Return the sides of a rectangle on a face of the cube, -1 to 1, around what is seen of a box;
    the first above the second where nothing is."""
    axis, one, two = face % 3, (face + 1) % 3, (face + 2) % 3
    middle = way[axis] if face < 3 else -way[axis]
    nearest, farthest = middle - halves[axis], middle + halves[axis]
    a, b = abs(way[one]) - halves[one], abs(way[two]) - halves[two]
    if farthest <= 0.0 or a > farthest or b > farthest:
        return 1.0, -1.0, 1.0, -1.0
    if nearest <= TOO_NEAR * farthest:
        return -1.0, 1.0, -1.0, 1.0
    left, right = _range(way[one], halves[one], nearest, farthest)
    low, high = _range(way[two], halves[two], nearest, farthest)
    return left, right, low, high


@njit(**INNER)
def _range(middle, half, nearest, farthest):
    low, high = middle - half, middle + half
    low = low / (nearest if low < 0.0 else farthest)
    high = high / (farthest if high < 0.0 else nearest)
    return max(low - ROUNDING, -1.0), min(high + ROUNDING, 1.0)


@njit(**INNER)
def _fill(squares, left, right, low, high):
    side = len(squares)
    first, last = _square(low, side), _square(high, side)
    for row in range(_square(left, side), _square(right, side) + 1):
        for column in range(first, last + 1):
            squares[row, column] = True


@njit(**INNER)
def _square(place, side):
    return min(np.int64((place + 1.0) * (0.5 * side)), side - 1)
