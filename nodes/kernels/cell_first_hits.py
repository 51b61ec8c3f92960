"""Which cells of a surface are the first that rays to its cells meet, and from which camera first.

A cell that no ray has met yet is met only by rays that go through its box. So the directions to
such cells are drawn into a map, and rays are traced in these directions only: from the first
cameras almost all, from later ones few.
"""

import numpy as np
from numba import njit

from nodes.kernels.cell_lists import (
    SLACK,
    entry_cell,
    fit_box,
    mark_lists,
    measure_list_shaft,
    move_list,
    take_out,
)
from nodes.kernels.cell_rays import (
    FINE,
    HALF,
    NOWHERE,
    SHARES,
    aim_camera,
    first_obstacle,
    is_in_view,
    way_to,
)
from nodes.kernels.cell_visibility import mark
from nodes.kernels.crisp_options import INNER, OUTER
from nodes.kernels.direction_maps import (
    COARSE_SIDE,
    FACES,
    FINE_SIDE,
    draw_box,
    is_box_drawn,
    is_drawn,
)

CORNER = 0.8661 * FINE  # from a cell's centre to its corners, rounded up


@njit(**OUTER)
def look_for_first_hits(surface, lists, blocks, cameras, views, squared_cosine, first, first_nodes):
    """Mark which cells of the lists are met first; the same cells as `look_plainly` marks.

    Other cells may be marked, too, but not from all cameras from which they are met.

    Parameters
    ----------
    lists : Lists of free faces of cells that have not been met; changed: what is met is taken out.
    blocks : Lists of all cells.
    cameras, views, squared_cosine, first, first_nodes : as in `look_plainly`.
    """
    size, blind = len(lists.counts), 0
    near, aims = np.empty(size, np.bool_), np.empty(len(blocks.counts), np.bool_)
    fine = np.zeros((FACES, FINE_SIDE, FINE_SIDE), np.bool_)
    coarse = np.zeros((FACES, COARSE_SIDE, COARSE_SIDE), np.bool_)
    for node in range(len(cameras)):
        camera = aim_camera(
            surface.free, surface.index_from_patient, cameras[node], views[node], squared_cosine
        )
        if camera.place[0] == NOWHERE:
            blind += 1
            continue
        mark_lists(lists, size, camera, CORNER, near)
        drawn = False
        for n in range(size - 1, -1, -1):
            if not near[n] or not _may_meet(lists, n, camera.place):
                continue
            _take_met(lists, n, first + node, first_nodes)
            if lists.counts[n] == 0:
                size -= 1
                move_list(lists, size, n)
            elif _draw(surface.room, lists, n, camera.place, fine, coarse):
                drawn = True
        if not drawn:
            continue
        mark_lists(blocks, len(blocks.counts), camera, 0.0, aims)
        for n in range(len(blocks.counts)):
            if aims[n] and is_box_drawn(coarse, *_box(blocks, n, camera.place)):
                _trace(surface, blocks, n, camera, fine, first + node, first_nodes)
        fine[:], coarse[:] = False, False
    return blind


@njit(**INNER)
def _box(lists, n, place):
    """Return the way to the middle of a list's box, and half of its sides."""
    middles, halves = lists.middles, lists.halves
    way = middles[0, n] - place[0], middles[1, n] - place[1], middles[2, n] - place[2]
    return way, (halves[0, n], halves[1, n], halves[2, n])


@njit(**INNER)
def _may_meet(lists, n, place):
    """Return whether a ray may come to a cell of the list over its free face."""
    face, axis = lists.faces[n], lists.faces[n] % 3
    towards = (lists.middles[axis, n] - place[axis]) * (-1.0 if face > 2 else 1.0)
    return towards + lists.halves[axis, n] >= HALF


@njit(**INNER)
def _draw(room, lists, n, place, fine, coarse):
    """Draw the box around a list's cells, unless none of them may be met; return whether it was."""
    if measure_list_shaft(room, lists, n, place, 0.5) < 0:
        return False
    way, (a, b, c) = _box(lists, n, place)
    half = float(HALF + SLACK)
    draw_box(fine, coarse, way, (a + half, b + half, c + half))
    return True


@njit(**INNER)
def _take_met(lists, n, node, first_nodes):
    """Take out what has been met by this node or before."""
    start, before = lists.starts[n], lists.counts[n]
    for entry in range(start + before - 1, start - 1, -1):
        if 0 <= first_nodes[lists.members[entry]] <= node:
            take_out(lists, n, entry)
    if 0 < lists.counts[n] < before:
        fit_box(lists, n)


@njit(**INNER)
def _trace(surface, blocks, n, camera, fine, node, first_nodes):
    """Mark what the rays to a block's cells meet first, in the directions that are drawn."""
    start, place, begin = blocks.starts[n], camera.place, np.int64(-1)
    for entry in range(start, start + blocks.counts[n]):
        i, j, k = entry_cell(blocks, entry)
        way = way_to(place, i, j, k)
        if is_in_view(way, camera) and is_drawn(fine, way):
            if begin < 0:
                open_to = measure_list_shaft(surface.room, blocks, n, place, 0.0)
                begin = np.int64((open_to if open_to >= 0 else -1.0 - open_to) * SHARES)
            met = first_obstacle(surface.free, place, i, j, k, begin)
            mark(first_nodes, surface.numbers[met], node)
