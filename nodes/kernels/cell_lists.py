"""Lists of neighbouring cells of a surface that a free cell touches over the same face.

From a cell's centre a ray leaves over the face towards which it goes farthest, so a camera sees a
cell only over one of its free faces, and of a list often none. What is said here of whole lists is
on the safe side: a list that is passed over holds no cell that a camera sees.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.cell_rays import BITS, FINE
from nodes.kernels.crisp_options import INNER

SLACK = 64.0  # against rounding, 2^-10 of a cell
LEAST_STEP = 1.5  # cells, along a shaft; by trying


class Lists(NamedTuple):
    """Cells in lists; what has been seen is taken out, and lists that are empty, too.

    members : (entry,) int32 numbers of cells; a cell is in a list for each of its free faces.
    centres : (3, entry) int32, of these cells, in 2^-16 of a cell from the grid's first corner.
    starts, counts : (list,) int64, the entries of each list.
    faces : (list,) int64: axis, and 3 more where the free cell is on the side of larger indices.
    middles, halves : (3, list) float64 of the box around the list's centres.
    """

    members: np.ndarray
    centres: np.ndarray
    starts: np.ndarray
    counts: np.ndarray
    faces: np.ndarray
    middles: np.ndarray
    halves: np.ndarray


@njit(**INNER)
def mark_lists(lists, size, camera, beside, near):
    """Mark which of the first lists may hold cells whose centres are in the field of view, or
    `beside` it at most so far, in 2^-16 of a cell."""
    place, axis = camera.place, camera.axis
    cosine, sine = np.sqrt(camera.squared_cosine), np.sqrt(1.0 - camera.squared_cosine)
    middles, halves = lists.middles, lists.halves
    a, b, c = float(place[0]), float(place[1]), float(place[2])
    for n in range(size):
        x, y, z = middles[0, n] - a, middles[1, n] - b, middles[2, n] - c
        u, v, w = halves[0, n], halves[1, n], halves[2, n]
        along = x * axis[0] + y * axis[1] + z * axis[2]
        across = np.sqrt(max(0.0, x * x + y * y + z * z - along * along))
        room = np.sqrt(u * u + v * v + w * w) + beside + SLACK
        near[n] = across * cosine - along * sine <= room


@njit(**INNER)
def may_face(lists, n, place):
    """Return whether a camera may see a cell of the list over its free face."""
    face, axis = lists.faces[n], lists.faces[n] % 3
    towards = (lists.middles[axis, n] - place[axis]) * (-1.0 if face > 2 else 1.0)
    towards += lists.halves[axis, n]
    for other in range(3):
        aside = abs(lists.middles[other, n] - place[other]) - lists.halves[other, n]
        if other != axis and aside > towards:
            return False
    return towards >= 0


@njit(**INNER)
def measure_list_shaft(room, lists, n, place, beside):
    """Return `measure_shaft` of a list's box and what is at most `beside`, cells, from it."""
    x = lists.middles[0, n] - place[0]
    y = lists.middles[1, n] - place[1]
    z = lists.middles[2, n] - place[2]
    width = max(lists.halves[0, n], lists.halves[1, n], lists.halves[2, n]) / FINE + beside
    return measure_shaft(room, place, x, y, z, width)


@njit(**INNER)
def measure_shaft(room, place, x, y, z, width):
    """Follow the shaft from a place to a cube.

    Parameters
    ----------
    x, y, z : way to the cube's middle, in 2^-16 of a cell.
    width : half of its side, cells.

    Returns
    -------
    share of the way up to which all rays to places in the cube are free; where all of them are
    stopped before they come to the cell of their place, -1 less that share.
    """
    width += SLACK / FINE
    length = max(abs(x), abs(y), abs(z)) / FINE
    last = 1.0 - 1.5 / max(length - width, 1.5)  # beyond it rays may be in the place's own cell
    open_to, is_open, way, thinnest = 0.0, True, 0.0, 1.0 + SLACK / FINE
    while way < last:
        i = (place[0] + np.int64(way * x)) >> BITS
        j = (place[1] + np.int64(way * y)) >> BITS
        k = (place[2] + np.int64(way * z)) >> BITS
        cells = np.int64(room[i, j, k])
        left = abs(cells) - thinnest - way * width
        if cells < 0 and left >= 0:
            return -1.0 - open_to
        step = LEAST_STEP
        if cells > 0:
            # rays that begin here stay in the free cube around this cell for so long
            free = left / (length + width) * length
            if is_open and free > 0:
                open_to = way + free / length
            is_open = is_open and free >= LEAST_STEP
            step = max(step, free if is_open else cells - 1.0)
        elif cells < 0:
            step = max(step, -left)
        way += step / length
    return min(open_to, last)


@njit(**INNER)
def entry_cell(lists, entry):
    """Return the indices of an entry's cell."""
    i, j, k = lists.centres[0, entry], lists.centres[1, entry], lists.centres[2, entry]
    return np.int64(i) >> BITS, np.int64(j) >> BITS, np.int64(k) >> BITS


@njit(**INNER)
def take_out(lists, n, entry):
    """Take an entry out of a list."""
    lists.counts[n] -= 1
    last = lists.starts[n] + lists.counts[n]
    lists.members[entry] = lists.members[last]
    for axis in range(3):
        lists.centres[axis, entry] = lists.centres[axis, last]


@njit(**INNER)
def fit_box(lists, n):
    """Fit the box to what is left in a list that is not empty."""
    start, stop = lists.starts[n], lists.starts[n] + lists.counts[n]
    for axis in range(3):
        low = high = lists.centres[axis, start]
        for entry in range(start + 1, stop):
            low = min(low, lists.centres[axis, entry])
            high = max(high, lists.centres[axis, entry])
        lists.middles[axis, n] = (float(low) + float(high)) / 2
        lists.halves[axis, n] = (float(high) - float(low)) / 2


@njit(**INNER)
def move_list(lists, origin, to):
    """Put a list into the place of another."""
    lists.starts[to], lists.counts[to] = lists.starts[origin], lists.counts[origin]
    lists.faces[to] = lists.faces[origin]
    for axis in range(3):
        lists.middles[axis, to] = lists.middles[axis, origin]
        lists.halves[axis, to] = lists.halves[axis, origin]
