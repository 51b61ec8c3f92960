"""Straight needles through labelled voxels: which reach the free space, and how near to bone."""

from typing import NamedTuple

import numpy as np
from numba import njit

OUTSIDE, WALL, FREE, FORBIDDEN = 0, 1, 2, 3  # what a voxel is to a needle


class NeedleRules(NamedTuple):
    """What a needle keeps to, mm: least distance of its axis to forbidden voxels, longest way in
    the wall, way into the free space, distance of the places along it that are looked at, and how
    far outside of the skin it starts at most."""

    clearance: float
    thickest_wall: float
    depth: float
    step: float
    run_up: float


@njit(cache=True, nogil=True, error_model="numpy")
def trace_needles(starts, directions, kinds, distance, spacing, rules, found, nearest):
    """Follow each direction from each start until the needle is in the free space or may not go on.

    Places `step` apart along the axis keep `clearance + step / 2` from all forbidden voxels' boxes,
    so all between them keep `clearance`.

    Parameters
    ----------
    starts : (n, d, 3) float64, mm along the grid's axes from the first voxel's centre, outside of
        the skin.
    directions : (n, d, 3) float64 unit vectors along the grid's axes.
    kinds : (i, j, k) uint8, one of OUTSIDE, WALL, FREE, FORBIDDEN.
    distance : (i, j, k) float32, of voxel centres to the nearest forbidden voxel's box, mm.
    spacing : (3,) float64 mm.
    rules : NeedleRules.
    found : (n, d, 2) float64, written: way from the start to the skin and to the free space, mm;
        nan where the needle may not pass.
    nearest : (n, d) float64, written: distance of the axis from the skin to the tip from forbidden
        voxels, mm, at voxel centres along it.
    """
    for n in range(starts.shape[0]):
        for d in range(directions.shape[1]):
            skin, wall, least = _trace(
                starts[n, d], directions[n, d], kinds, distance, spacing, rules
            )
            found[n, d, 0], found[n, d, 1], nearest[n, d] = skin, wall, least


@njit(cache=True, nogil=True, error_model="numpy")
def _trace(start, direction, kinds, distance, spacing, rules):
    skin, pleura, least = np.nan, np.nan, np.inf
    refused = np.nan, np.nan, 0.0
    way, limit, air = 0.0, rules.run_up, False
    while way <= limit:
        x = start[0] + way * direction[0]
        y = start[1] + way * direction[1]
        z = start[2] + way * direction[2]
        i, j, k = _nearest(x, spacing[0]), _nearest(y, spacing[1]), _nearest(z, spacing[2])
        if min(i, j, k) < 0 or i >= kinds.shape[0] or j >= kinds.shape[1] or k >= kinds.shape[2]:
            if skin == skin:
                return refused
            way += rules.step
            continue
        kind = kinds[i, j, k]
        if kind == OUTSIDE:
            air = True
        elif skin != skin:
            if not air:  # the image's edge cuts the body here: what lies before it is not known
                return refused
            skin, limit = way, way + rules.thickest_wall
        if kind == FREE and pleura != pleura:
            pleura, limit = way, way + rules.depth
        if (
            kind == FORBIDDEN
            or (kind == OUTSIDE and skin == skin)
            or (kind == WALL and pleura == pleura)
        ):
            return refused
        if skin == skin:
            least = min(least, distance[i, j, k])
            if _is_near(x, y, z, i, j, k, kinds, distance, spacing, rules):
                return refused
        way += rules.step
    if pleura != pleura or pleura == skin:
        return refused
    return skin, pleura, least


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(place, step):
    return int(np.floor(place / step + 0.5))


@njit(cache=True, nogil=True, error_model="numpy")
def _is_near(x, y, z, i, j, k, kinds, distance, spacing, rules):
    """Return whether the place is nearer to a forbidden voxel's box than the needle may be.

    The distance at the voxel's centre decides unless the way there leaves it open; then the boxes
    around are measured.
    """
    wanted = rules.clearance + rules.step / 2
    off = np.sqrt((x - i * spacing[0]) ** 2 + (y - j * spacing[1]) ** 2 + (z - k * spacing[2]) ** 2)
    if distance[i, j, k] - off >= wanted:
        return False
    if distance[i, j, k] + off < wanted:
        return True
    reach = wanted / spacing + 1.0
    for a in range(max(0, int(i - reach[0])), min(kinds.shape[0], int(i + reach[0]) + 2)):
        dx = max(abs(x - a * spacing[0]) - spacing[0] / 2, 0.0)
        for b in range(max(0, int(j - reach[1])), min(kinds.shape[1], int(j + reach[1]) + 2)):
            dy = max(abs(y - b * spacing[1]) - spacing[1] / 2, 0.0)
            if dx * dx + dy * dy >= wanted * wanted:
                continue
            for c in range(max(0, int(k - reach[2])), min(kinds.shape[2], int(k + reach[2]) + 2)):
                if kinds[a, b, c] == FORBIDDEN:
                    dz = max(abs(z - c * spacing[2]) - spacing[2] / 2, 0.0)
                    if dx * dx + dy * dy + dz * dz < wanted * wanted:
                        return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def mark_segments(starts, ends, spacing, step, cell, marked):
    """Mark the cells that hold the centre of a voxel that a segment crosses, looked at every step.

    Parameters
    ----------
    starts, ends : (n, 3) float64 mm.
    spacing : (3,) float64 mm, of the voxels.
    step : distance of the places that are looked at, mm.
    cell : size of the cells, mm; the first one begins at the first voxel's centre.
    marked : (a, b, c) bool, written.
    """
    for n in range(len(starts)):
        way = ends[n] - starts[n]
        count = int(np.ceil(np.sqrt(np.sum(way * way)) / step)) + 1
        for place in range(count + 1):
            share = place / count
            i = _cell(starts[n, 0] + share * way[0], spacing[0], cell, marked.shape[0])
            j = _cell(starts[n, 1] + share * way[1], spacing[1], cell, marked.shape[1])
            k = _cell(starts[n, 2] + share * way[2], spacing[2], cell, marked.shape[2])
            marked[i, j, k] = True


@njit(cache=True, nogil=True, error_model="numpy")
def _cell(place, step, cell, size):
    return min(max(int(np.floor(_nearest(place, step) * step / cell)), 0), size - 1)


@njit(cache=True, nogil=True, error_model="numpy")
def segment_clearance(start, end, boxes, half):
    """Return the least distance between a segment and boxes of one size, mm.

    The squared distance to a box is convex along the segment, so each is found by narrowing down.

    Parameters
    ----------
    start, end : (3,) float64 mm.
    boxes : (n, 3) float64 centres, mm.
    half : (3,) float64 half of the boxes' sides, mm.
    """
    best, room = np.inf, np.sqrt(np.sum(half * half))
    along = end - start
    length = max(np.sum(along * along), 1e-12)
    for n in range(boxes.shape[0]):
        # The way to a box's centre shows for most boxes that others are nearer.
        share = min(max(np.sum((boxes[n] - start) * along) / length, 0.0), 1.0)
        if np.sqrt(np.sum((start + share * along - boxes[n]) ** 2)) - room >= best:
            continue
        low, high = 0.0, 1.0
        for _ in range(40):
            one, two = low + (high - low) / 3, high - (high - low) / 3
            if _to_box(start, end, one, boxes[n], half) < _to_box(start, end, two, boxes[n], half):
                high = two
            else:
                low = one
        best = min(best, _to_box(start, end, (low + high) / 2, boxes[n], half))
    return best


@njit(cache=True, nogil=True, error_model="numpy")
def _to_box(start, end, share, box, half):
    squared = 0.0
    for axis in range(3):
        place = start[axis] + share * (end[axis] - start[axis])
        away = max(abs(place - box[axis]) - half[axis], 0.0)
        squared += away * away
    return np.sqrt(squared)
