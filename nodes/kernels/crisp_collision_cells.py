"""Whether capsules and balls touch the boxes of cells that are not free, exactly.

Places are in mm along the grid's axes, from the centre of the first cell. `room` is exact at cells'
centres and changes by no more than the way, so it settles most capsules without a look at boxes.
"""

from math import floor, sqrt

import numpy as np
from numba import njit

from nodes.kernels.box_distance import is_near_box
from nodes.kernels.crisp_collision_options import INSIDE


@njit(**INSIDE)
def to_grid(space, x, y, z):
    """Return a place in patient mm in mm along the grid's axes."""
    a, s = space.index_from_patient, space.spacing
    return (
        s[0] * (a[0, 0] * x + a[0, 1] * y + a[0, 2] * z + a[0, 3]),
        s[1] * (a[1, 0] * x + a[1, 1] * y + a[1, 2] * z + a[1, 3]),
        s[2] * (a[2, 0] * x + a[2, 1] * y + a[2, 2] * z + a[2, 3]),
    )


@njit(**INSIDE)
def is_within_grid(space, start, end, radius):
    """Return whether all of a capsule lies in the grid; False for nan."""
    return min(border_at(space, start), border_at(space, end)) >= radius


@njit(**INSIDE)
def border_at(space, point):
    """Return the distance from a place in the grid to what lies beyond; less than 0 there."""
    x = _to_border(point[0], space.spacing[0], space.free.shape[0])
    y = _to_border(point[1], space.spacing[1], space.free.shape[1])
    z = _to_border(point[2], space.spacing[2], space.free.shape[2])
    return min(x, min(y, z))


@njit(**INSIDE)
def _to_border(place, spacing, count):
    return min(place + 0.5 * spacing, (count - 0.5) * spacing - place)


@njit(**INSIDE)
def touches_cells(space, start, end, radius):
    """Return whether a capsule touches the box of any cell of the grid that is not free."""
    wx, wy, wz = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    length = sqrt(wx * wx + wy * wy + wz * wz)
    cell = min(space.spacing[0], space.spacing[1], space.spacing[2])
    done, part = 0.0, 1.0
    while done < 1.0:
        share = done + 0.5 * part
        half = 0.5 * part * length
        room = room_at(space, start[0] + share * wx, start[1] + share * wy, start[2] + share * wz)
        if room < half + radius:
            if half > cell:
                part *= 0.5
                continue
            near = start[0] + done * wx, start[1] + done * wy, start[2] + done * wz
            if _touches_boxes(space, near, (part * wx, part * wy, part * wz), radius):
                return True
        done += part
        part = min(2.0 * part, 1.0 - done)
    return False


@njit(**INSIDE)
def room_at(space, x, y, z):
    """Return a bound from below of the distance to the nearest box that is not free.

    The nearest cell's centre stands for places beyond the grid.
    """
    i, dx = _nearest(x, space.spacing[0], space.free.shape[0])
    j, dy = _nearest(y, space.spacing[1], space.free.shape[1])
    k, dz = _nearest(z, space.spacing[2], space.free.shape[2])
    return space.room[i, j, k] - sqrt(dx * dx + dy * dy + dz * dz)


@njit(**INSIDE)
def distance_within(space, point, reach):
    """Return the distance from a point in the grid to the nearest box that is not free, or `reach`
    if that is nearer."""
    i, dx = _nearest(point[0], space.spacing[0], space.free.shape[0])
    j, dy = _nearest(point[1], space.spacing[1], space.free.shape[1])
    k, dz = _nearest(point[2], space.spacing[2], space.free.shape[2])
    if space.room[i, j, k] - sqrt(dx * dx + dy * dy + dz * dz) >= reach:
        return reach
    if space.free[i, j, k] == 0:
        return 0.0
    least = reach * reach
    ax, bx = _range(point[0], point[0], reach, space.spacing[0], space.free.shape[0])
    ay, by = _range(point[1], point[1], reach, space.spacing[1], space.free.shape[1])
    az, bz = _range(point[2], point[2], reach, space.spacing[2], space.free.shape[2])
    for i in range(ax, bx):
        x = _square_beyond(point[0], i, space.spacing[0])
        for j in range(ay, by):
            xy = x + _square_beyond(point[1], j, space.spacing[1])
            if xy < least:
                for k in range(az, bz):
                    if space.free[i, j, k] == 0:
                        least = min(least, xy + _square_beyond(point[2], k, space.spacing[2]))
    return sqrt(least)


@njit(**INSIDE)
def _touches_boxes(space, start, way, radius):
    ax, bx = _range(start[0], start[0] + way[0], radius, space.spacing[0], space.free.shape[0])
    ay, by = _range(start[1], start[1] + way[1], radius, space.spacing[1], space.free.shape[1])
    az, bz = _range(start[2], start[2] + way[2], radius, space.spacing[2], space.free.shape[2])
    for i in range(ax, bx):
        for j in range(ay, by):
            for k in range(az, bz):
                if space.free[i, j, k] == 0:
                    low, high = _box(space, i, j, k)
                    if is_near_box(start, way, low, high, radius):
                        return True
    return False


@njit(**INSIDE)
def _square_beyond(place, cell, spacing):
    away = max(abs(place - cell * spacing) - 0.5 * spacing, 0.0)
    return away * away


@njit(**INSIDE)
def _box(space, i, j, k):
    s = space.spacing
    low = (i - 0.5) * s[0], (j - 0.5) * s[1], (k - 0.5) * s[2]
    return low, (low[0] + s[0], low[1] + s[1], low[2] + s[2])


@njit(**INSIDE)
def _range(start, end, radius, spacing, count):
    """Return the cells, first and beyond the last, that lie within a radius of an interval."""
    first = floor((min(start, end) - radius) / spacing + 0.5)
    last = floor((max(start, end) + radius) / spacing + 0.5)
    return max(np.int64(first), np.int64(0)), min(np.int64(last) + 1, count)


@njit(**INSIDE)
def _nearest(place, spacing, count):
    """Return the cell, within the grid, whose centre is nearest, and the way from there."""
    cell = min(max(np.int64(floor(place / spacing + 0.5)), np.int64(0)), np.int64(count - 1))
    return cell, place - cell * spacing
