"""Lines of sight by fractions, and by slabs: nothing shared with the kernels that they judge."""

from fractions import Fraction

import numpy as np


def ray_cells(camera, cell):
    """Return the cells on the ray from a place (index coordinates) to a cell's centre, in order.

    The faces between the two are sorted by where the ray, shifted by (e, e^2, e^3) with an
    infinitely small e, crosses them: the place of a crossing is a polynomial in e.
    """
    start = [Fraction(round((float(x) + 0.5) * 65536), 65536) for x in camera]
    end = [Fraction(2 * int(index) + 1, 2) for index in cell]
    now = [x.numerator // x.denominator for x in start]  # the shift is towards larger indices
    crossings = []
    for axis in range(3):
        way = end[axis] - start[axis]
        sign = 1 if end[axis] > start[axis] else -1
        faces = range(now[axis] + 1, int(cell[axis]) + 1)
        if sign < 0:
            faces = range(now[axis], int(cell[axis]), -1)
        for face in faces:
            powers = [Fraction(0)] * 3
            powers[axis] = -1 / way
            crossings.append(((face - start[axis]) / way, *powers, axis, sign))
    cells = [tuple(now)]
    for *_, axis, sign in sorted(crossings):
        now[axis] += sign
        cells.append(tuple(now))
    return cells


def slab_stops(camera, cell, obstacles):
    """Return whether the straight way to a cell's centre passes through any of the obstacle boxes;
    None where it touches one too slightly to say."""
    start = np.round((np.asarray(camera) + 0.5) * 65536) / 65536
    way = np.asarray(cell) + 0.5 - start
    with np.errstate(divide="ignore", invalid="ignore"):
        one, two = (obstacles - start) / way, (obstacles + 1 - start) / way
    inside = (start > obstacles) & (start < obstacles + 1)
    one = np.where(way == 0, np.where(inside, -np.inf, np.inf), one)
    two = np.where(way == 0, np.where(inside, np.inf, -np.inf), two)
    enter = np.maximum(np.minimum(one, two).max(axis=1), 0)
    leave = np.minimum(np.maximum(one, two).min(axis=1), 1)
    if (abs(leave - enter) < 1e-9).any():
        return None
    return bool((leave > enter).any())
