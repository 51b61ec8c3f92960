"""Which cells of a surface are seen from many cameras, and from which first."""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.cell_lists import (
    entry_cell,
    fit_box,
    mark_lists,
    may_face,
    measure_list_shaft,
    move_list,
    take_out,
)
from nodes.kernels.cell_rays import (
    NOWHERE,
    aim_camera,
    first_obstacle,
    is_in_view,
    is_ray_free,
    steps_along,
    way_to,
)
from nodes.kernels.crisp_options import INNER, OUTER

FEW = 3  # rays that are sooner traced than their shaft is followed


class Surface(NamedTuple):
    """The cells that may be seen, in the grid around them.

    cells : (cell, 3) int32 indices.
    numbers : (i, j, k) int32, of each cell in `cells`, or -1.
    free : (i, j, k) uint8, 1 where one sees through.
    room : (i, j, k) int8, how many cells away along the axes (at most) the next one is that is not
        free, or, negative, the next free one.
    index_from_patient : (3, 4) float64.
    """

    cells: np.ndarray
    numbers: np.ndarray
    free: np.ndarray
    room: np.ndarray
    index_from_patient: np.ndarray


@njit(**OUTER)
def look_plainly(surface, cameras, views, squared_cosine, first_hit, first, first_nodes):
    """Mark which cells are seen, one ray a cell and camera, and return how many cameras are blind
    because they are not in a free cell.

    Parameters
    ----------
    cameras, views : (node, 3) float64 mm and directions in patient axes.
    squared_cosine : of half the field of view.
    first_hit : mark the first cell that is not free on each ray, not the one that it is led to.
    first : number of the first of these nodes.
    first_nodes : (cell,) int64, changed: the least number of a node that sees each cell, or -1.
    """
    free, blind = surface.free, 0
    for node in range(len(cameras)):
        camera = aim_camera(
            surface.free, surface.index_from_patient, cameras[node], views[node], squared_cosine
        )
        place = camera.place
        if place[0] == NOWHERE:
            blind += 1
            continue
        for cell in range(len(surface.cells)):
            i, j, k = _cell(surface, cell)
            if not is_in_view(way_to(place, i, j, k), camera):
                continue
            met = surface.numbers[first_obstacle(free, place, i, j, k, np.int64(0))]
            if first_hit or met == cell:
                mark(first_nodes, met, first + node)
    return blind


@njit(**INNER)
def _cell(surface, cell):
    i, j, k = surface.cells[cell, 0], surface.cells[cell, 1], surface.cells[cell, 2]
    return np.int64(i), np.int64(j), np.int64(k)


@njit(**INNER)
def mark(first_nodes, cell, node):
    """Let a cell be seen by a node, if it is one of the surface and no earlier one has seen it."""
    if cell >= 0 and not 0 <= first_nodes[cell] <= node:
        first_nodes[cell] = node


@njit(**OUTER)
def look_at_lists(surface, lists, cameras, views, squared_cosine, first, first_nodes):
    """Mark which cells of the lists are seen themselves, as `look_plainly` does, but fast.

    Parameters
    ----------
    lists : Lists of free faces of cells not seen yet; changed: what is seen is taken out.
    cameras, views, squared_cosine, first, first_nodes : as in `look_plainly`, and what is returned.
    """
    size, blind = len(lists.counts), 0
    near, seen = np.empty(size, np.bool_), np.empty(len(lists.members), np.bool_)
    for node in range(len(cameras)):
        camera = aim_camera(
            surface.free, surface.index_from_patient, cameras[node], views[node], squared_cosine
        )
        place = camera.place
        if place[0] == NOWHERE:
            blind += 1
            continue
        mark_lists(lists, size, camera, 0.0, near)
        for n in range(size - 1, -1, -1):
            if not near[n] or not may_face(lists, n, place):
                continue
            if not _look_at_list(surface, lists, n, camera, first + node, first_nodes, seen):
                continue
            _take_seen(lists, n, seen)
            if lists.counts[n] == 0:
                size -= 1
                move_list(lists, size, n)
    return blind


@njit(**OUTER)
def look_at_lists_anew(surface, lists, cameras, views, squared_cosine, seen):
    """Write what each camera sees by itself, whatever the others see.

    Parameters
    ----------
    lists : Lists of free faces of all cells; not changed.
    cameras, views, squared_cosine : as in `look_plainly`.
    seen : (node, cell) bool, written.
    """
    size, zero = len(lists.counts), np.int64(0)
    near, facing = np.empty(size, np.bool_), np.empty(len(lists.members), np.bool_)
    first_nodes = np.empty(len(surface.cells), np.int64)
    for node in range(len(cameras)):
        first_nodes[:] = -1
        camera = aim_camera(
            surface.free, surface.index_from_patient, cameras[node], views[node], squared_cosine
        )
        if camera.place[0] != NOWHERE:
            mark_lists(lists, size, camera, 0.0, near)
            for n in range(size):
                if near[n] and may_face(lists, n, camera.place):
                    _look_at_list(surface, lists, n, camera, zero, first_nodes, facing)
        for cell in range(len(first_nodes)):
            seen[node, cell] = first_nodes[cell] == 0


@njit(**INNER)
def _look_at_list(surface, lists, n, camera, node, first_nodes, seen):
    """Mark which entries of a list are seen, now or before; return whether any may be."""
    count = _find_facing(lists, n, camera, seen)
    open_to = 0.0
    if count > FEW:
        open_to = measure_list_shaft(surface.room, lists, n, camera.place, 0.0)
    if count == 0 or open_to < 0:
        return False
    _trace(surface.free, lists, n, camera.place, 1.0 - open_to, node, first_nodes, seen)
    return True


@njit(**INNER)
def _find_facing(lists, n, camera, facing):
    """Mark the list's entries in the field of view that a ray may reach over their free face."""
    start, count = lists.starts[n], lists.counts[n]
    forward, face = lists.faces[n] % 3, lists.faces[n]
    sign = -1.0 if face > 2 else 1.0
    xs, ys, zs = lists.centres[0], lists.centres[1], lists.centres[2]
    place = camera.place
    px, py, pz = float(place[0]), float(place[1]), float(place[2])
    found = 0
    for entry in range(count):
        x, y, z = xs[start + entry] - px, ys[start + entry] - py, zs[start + entry] - pz
        towards = sign * (x if forward == 0 else (y if forward == 1 else z))
        faces = (towards >= abs(x)) & (towards >= abs(y)) & (towards >= abs(z))
        facing[entry] = faces & is_in_view((x, y, z), camera)
        found += facing[entry]
    return found


@njit(**INNER)
def _trace(free, lists, n, place, share, node, first_nodes, seen):
    """Keep the marks of those entries of a list that are seen, now or before.

    share : of each ray, from its cell on, that has to be traced.
    """
    start = lists.starts[n]
    for entry in range(lists.counts[n]):
        if not seen[entry]:
            continue
        cell = lists.members[start + entry]
        if 0 <= first_nodes[cell] <= node:
            continue
        i, j, k = entry_cell(lists, start + entry)
        steps = steps_along(place, i, j, k, share)
        seen[entry] = is_ray_free(free, place, i, j, k, steps)
        if seen[entry]:
            first_nodes[cell] = node


@njit(**INNER)
def _take_seen(lists, n, seen):
    before = lists.counts[n]
    for entry in range(before - 1, -1, -1):
        if seen[entry]:
            take_out(lists, n, lists.starts[n] + entry)
    if 0 < lists.counts[n] < before:
        fit_box(lists, n)
