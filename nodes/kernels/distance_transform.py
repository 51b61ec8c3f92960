"""Exact distance from cell centres to the faces between a mask and all else.

For a cell of the mask this is the distance to the nearest point of any box outside of it, and the
other way round. Per axis, a box i cells away begins at g(i) = (|i| - 1/2) h, g(0) = 0, so the
squared distance is a sum over axes and each axis is swept for itself [Felzenszwalb2012].
"""

import numpy as np
from numba import njit

LINES = 16  # swept together, so that reads of neighbouring lines share a cache line


@njit(cache=True, nogil=True, error_model="numpy")
def sweep(squared, mask, step, first, part, parts):
    """Lower squared distances by what the faces and cells along the middle axis allow.

    The height of each face between two cells is the smaller of theirs, 0 where the mask changes;
    the result is the lower envelope of parabolas over the faces of a cell's run. What lies beyond
    the next change is behind a face of height 0, so each run is swept for itself and one field
    serves mask and rest. Beyond the grid nothing is mask.

    Parameters
    ----------
    squared : (outer, n, inner) float32, changed in place; read only if not `first`.
    mask : (outer, n, inner) bool.
    step : cell size along the middle axis.
    first : True for the first axis, before which no distance is known.
    part, parts : which blocks of lines to sweep, so that threads share the work.
    """
    outer, n, inner = squared.shape
    blocks = (inner + LINES - 1) // LINES
    heights = np.empty((LINES, n), np.float64)
    inside = np.empty((LINES, n), np.bool_)
    faces, starts = np.empty(n + 1, np.int64), np.empty(n + 2, np.float64)
    edges = np.empty(n + 1, np.float64)
    for block in range(part, outer * blocks, parts):
        row, low = block // blocks, block % blocks * LINES
        high = min(low + LINES, inner)
        for i in range(n):
            for lane in range(low, high):
                heights[lane - low, i] = np.inf if first else squared[row, i, lane]
                inside[lane - low, i] = mask[row, i, lane]
        for lane in range(high - low):
            _sweep_line(heights[lane], inside[lane], step, edges, faces, starts)
        for i in range(n):
            for lane in range(low, high):
                squared[row, i, lane] = heights[lane - low, i]


@njit(cache=True, nogil=True, error_model="numpy")
def _sweep_line(heights, inside, step, edges, faces, starts):
    """Sweep each run of equal cells of one line; `edges[i]` is the height of the face before i."""
    n = len(heights)
    begin = 0
    while begin < n:
        end = begin + 1
        while end < n and inside[end] == inside[begin]:
            end += 1
        for i in range(begin + 1, end):
            edges[i] = min(heights[i - 1], heights[i])
        edges[begin] = 0.0 if begin > 0 or inside[begin] else np.inf
        edges[end] = 0.0 if end < n or inside[begin] else np.inf
        _envelope(heights, edges, begin, end, step, faces, starts)
        begin = end


@njit(cache=True, nogil=True, error_model="numpy")
def _envelope(heights, edges, begin, end, step, faces, starts):
    """Lower the heights of cells begin..end - 1 to the parabolas over the faces begin..end."""
    count = 0
    for face in range(begin, end + 1):
        if edges[face] == np.inf:
            continue
        start = -np.inf
        while count > 0:
            before = faces[count - 1]
            rise = (edges[face] - edges[before]) / (step * step)
            start = 0.5 * (rise / (face - before) + face + before)
            if start > starts[count - 1]:
                break
            count -= 1
            start = -np.inf
        faces[count], starts[count] = face, start
        count += 1
    if count == 0:
        return
    starts[count] = np.inf
    nearest = 0
    for i in range(begin, end):
        while starts[nearest + 1] < i + 0.5:
            nearest += 1
        away = (i + 0.5 - faces[nearest]) * step
        heights[i] = min(heights[i], edges[faces[nearest]] + away * away)
