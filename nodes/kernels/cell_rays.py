"""Lines of sight through a grid of cells, exact.

A camera's place is rounded to 2^-16 of a cell, and a ray runs between it and the centre of a cell.
All that is compared are whole numbers. A ray goes from cell to cell over one face at a time; where
it meets an edge or a corner, it goes as if it were shifted by an infinitely small way along i, one
infinitely smaller along j, and one smaller still along k. So it takes the same cells from either
end, and a camera on a face belongs to the cell with the larger index.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_options import INNER, OUTER

BITS, SHARE_BITS = 16, 10
FINE, HALF = 1 << BITS, 1 << (BITS - 1)  # places in a cell, and in half of one, along an axis
SHARES = 1 << SHARE_BITS  # of a ray
MOST_CELLS = 16384  # along an axis, for which 64 bits are by far enough
NOWHERE = -1


class Camera(NamedTuple):
    """A camera along a grid's axes.

    place : three int64, in 2^-16 of a cell from the grid's first corner; the first one is NOWHERE
        if the camera is not in a free cell.
    axis : three float64, unit vector of the direction of view.
    squared_cosine : of half the field of view.
    """

    place: tuple[int, int, int]
    axis: tuple[float, float, float]
    squared_cosine: float


@njit(**OUTER)
def sees_cell(free, index_from_patient, camera, view, squared_cosine, i, j, k):
    """Return whether a camera sees a cell: within its field of view, over free cells only.

    Parameters
    ----------
    free : (i, j, k) uint8, 1 where the space is free, so that one sees through.
    index_from_patient : (3, 4) float64; cells are cubes, and cell c covers c - 0.5 to c + 0.5.
    camera, view : (3,) float64 place, mm, and direction, any length but 0, in patient axes.
    squared_cosine : of half the field of view, which is at most 180 degrees.
    i, j, k : of the cell, which need not be free itself.
    """
    seer = aim_camera(free, index_from_patient, camera, view, squared_cosine)
    i, j, k = np.int64(i), np.int64(j), np.int64(k)
    if seer.place[0] == NOWHERE or not is_in_view(way_to(seer.place, i, j, k), seer):
        return False
    return is_ray_free(free, seer.place, i, j, k, steps_between(seer.place, i, j, k))


@njit(**INNER)
def aim_camera(free, index_from_patient, camera, view, squared_cosine):
    """Return the Camera at a place, mm, that looks along a direction in patient axes."""
    place = _place_camera(free, index_from_patient, camera)
    return Camera(place, _turn_view(index_from_patient, view), float(squared_cosine))


@njit(**INNER)
def _place_camera(free, index_from_patient, camera):
    """Return a place in 2^-16 of a cell from the grid's first corner; NOWHERE if it is not free."""
    a = _place(index_from_patient[0], camera, free.shape[0])
    b = _place(index_from_patient[1], camera, free.shape[1])
    c = _place(index_from_patient[2], camera, free.shape[2])
    if min(a, b, c) < 0 or not free[a >> BITS, b >> BITS, c >> BITS]:
        a = np.int64(NOWHERE)
    return a, b, c


@njit(**INNER)
def _place(row, camera, cells):
    index = row[0] * camera[0] + row[1] * camera[1] + row[2] * camera[2] + row[3]
    if not (-1.0 < index < cells):  # nan is nowhere
        return np.int64(NOWHERE)
    place = np.int64(np.rint((index + 0.5) * FINE))
    return place if 0 <= place < cells * FINE else np.int64(NOWHERE)


@njit(**INNER)
def _turn_view(index_from_patient, view):
    """Return the unit vector of a direction along the grid's axes."""
    x = _turn(index_from_patient[0], view)
    y = _turn(index_from_patient[1], view)
    z = _turn(index_from_patient[2], view)
    length = np.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


@njit(**INNER)
def _turn(row, view):
    return row[0] * view[0] + row[1] * view[1] + row[2] * view[2]


@njit(**INNER)
def way_to(place, i, j, k):
    """Return the way from a place to a cell's centre, in 2^-16 of a cell, exact."""
    x, y, z = _way_back(place[0], i), _way_back(place[1], j), _way_back(place[2], k)
    return float(-x), float(-y), float(-z)


@njit(**INNER)
def is_in_view(way, camera):
    """Return whether a way leads into the field of view; the one place where this is said."""
    x, y, z = way
    axis, squared_cosine = camera.axis, camera.squared_cosine
    along = x * axis[0] + y * axis[1] + z * axis[2]
    return (along >= 0) & (along * along >= squared_cosine * (x * x + y * y + z * z))


@njit(**INNER)
def steps_between(place, i, j, k):
    """Return how many faces a ray crosses between a place and a cell's centre."""
    return abs((place[0] >> BITS) - i) + abs((place[1] >> BITS) - j) + abs((place[2] >> BITS) - k)


@njit(**INNER)
def steps_along(place, i, j, k, share):
    """Return a number of faces, from the cell on, in which at least this share of a ray is done.

    Of the share t of a ray, whose ways along the axes are a, b and c cells, at most a t + 1/2 faces
    across the first axis are crossed, and so on.
    """
    x, y, z = way_to(place, i, j, k)
    steps = np.int64((abs(x) + abs(y) + abs(z)) / FINE * share) + 3
    return min(steps, steps_between(place, i, j, k))


@njit(**INNER)
def is_ray_free(free, place, i, j, k, steps):
    """Return whether all cells on the ray from a cell's centre to a place are free, but its own.

    From a centre the n-th face across i lies at (2 n - 1) half cells, so the ray comes to it before
    it comes to the m-th across j where (2 n - 1) |y| < (2 m - 1) |x|; the differences of such
    products are carried along.

    Parameters
    ----------
    free : (i, j, k) uint8.
    place : three int64, in 2^-16 of a cell.
    i, j, k : of the cell, int64.
    steps : number of faces to cross, `steps_between`, or less if the ray is known to be free there.
    """
    x, y, z = (
        place[0] - (i * FINE + HALF),
        place[1] - (j * FINE + HALF),
        place[2] - (k * FINE + HALF),
    )
    a, b, c = abs(x), abs(y), abs(z)
    up, over, out = _sign(x), _sign(y), _sign(z)
    # negative where the face across the former axis comes first; ties as the module says
    ij, ik, jk = b - a - (x > 0), c - a - (x > 0), c - b - (y > 0)
    for _ in range(steps):
        if ij < 0 and ik < 0:
            i += up
            ij += 2 * b
            ik += 2 * c
        elif ij >= 0 and jk < 0:
            j += over
            ij -= 2 * a
            jk += 2 * c
        else:
            k += out
            ik -= 2 * a
            jk -= 2 * b
        if not free[i, j, k]:
            return False
    return True


@njit(**INNER)
def first_obstacle(free, place, i, j, k, begin):
    """Return the first cell that is not free on the ray from a place in a free cell to a cell; that
    cell itself if there is none before.

    begin : in 1 / SHARES of the ray, up to where it is known to be free.
    """
    x, y, z = -_way_back(place[0], i), -_way_back(place[1], j), -_way_back(place[2], k)
    a, b, c = abs(x), abs(y), abs(z)
    up, over, out = _sign(x), _sign(y), _sign(z)
    first = _cell_at(place[0], x, begin)
    second = _cell_at(place[1], y, begin)
    third = _cell_at(place[2], z, begin)
    steps = abs(i - first) + abs(j - second) + abs(k - third)
    i, j, k = first, second, third
    u, v, w = _to_face(place[0], i, up), _to_face(place[1], j, over), _to_face(place[2], k, out)
    ij, ik, jk = u * b - v * a - (x > 0), u * c - w * a - (x > 0), v * c - w * b - (y > 0)
    for _ in range(steps):
        if ij < 0 and ik < 0:
            i += up
            ij += FINE * b
            ik += FINE * c
        elif ij >= 0 and jk < 0:
            j += over
            ij -= FINE * a
            jk += FINE * c
        else:
            k += out
            ik -= FINE * a
            jk -= FINE * b
        if not free[i, j, k]:
            break
    return i, j, k


@njit(**INNER)
def _way_back(place, index):
    """Return the way from a cell's centre to a place, along an axis."""
    return place - (index * FINE + HALF)


@njit(**INNER)
def _cell_at(place, way, share):
    """Return in which cell the share of a way ends, along an axis."""
    return (place * SHARES + way * share) >> (BITS + SHARE_BITS)


@njit(**INNER)
def _to_face(place, index, sign):
    """Return how far it is from a place to the face where a ray leaves a cell, along an axis."""
    return (index + 1) * FINE - place if sign > 0 else place - index * FINE


@njit(**INNER)
def _sign(way):
    return np.int64(1) if way > 0 else np.int64(-1)
