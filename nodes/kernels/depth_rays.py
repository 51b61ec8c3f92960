"""What a round camera sees of a smooth surface, as depth: rays that step by a distance field."""

import numpy as np
from numba import njit

from nodes.kernels.crisp_options import INNER, OUTER

CAUTION = 0.9  # share of the distance to go at once: between centres it is only interpolated
SHORTEST = 0.05  # of a step, cells
HALVINGS = 12  # of the last step, on which the surface is


@njit(**OUTER)
def trace_depth(distance, index_from_camera, half_angle, depth, normals):
    """Write how far the surface is in each pixel's direction, and the surface's direction there.

    Angles from the view grow evenly from the picture's middle to the circle that touches its sides.

    Parameters
    ----------
    distance : (i, j, k) float32 signed distance at cells' centres in cells, positive where free.
    index_from_camera : (4, 4) float64, of cubic cells.
    half_angle : of the cone, rad.
    depth : (h, w) float32, written: in cells along the ray; nan outside of the circle and where the
        camera itself is not in free space.
    normals : (h, w, 3) float32, written: unit vectors along the grid's axes, into the free space.
    """
    axes, start = index_from_camera[:3, :3], index_from_camera[:3, 3]
    height, width = depth.shape
    for row in range(height):
        for column in range(width):
            x, y = (2 * column + 1) / width - 1, (2 * row + 1) / height - 1
            radius = np.sqrt(x * x + y * y)
            depth[row, column] = np.nan
            normals[row, column] = np.nan
            if radius > 1 or _value(distance, start[0], start[1], start[2]) <= 0:
                continue
            out = np.sin(radius * half_angle) / max(radius, 1e-12)
            x, y, z = x * out, y * out, np.cos(radius * half_angle)
            a = axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z
            b = axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z
            c = axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z
            size = np.sqrt(a * a + b * b + c * c)
            a, b, c = a / size, b / size, c / size
            way = _follow(distance, start, a, b, c)
            depth[row, column] = way
            place = start[0] + way * a, start[1] + way * b, start[2] + way * c
            _write_normal(distance, place, normals[row, column])


@njit(**INNER)
def _follow(distance, start, a, b, c):
    """Return how far a ray goes while the distance is positive; at the grid's end it is not."""
    way, before = 0.0, 0.0
    longest = float(distance.shape[0] + distance.shape[1] + distance.shape[2])
    while way < longest:
        value = _value(distance, start[0] + way * a, start[1] + way * b, start[2] + way * c)
        if value <= 0:
            break
        before = way
        way += max(CAUTION * value, SHORTEST)
    for _ in range(HALVINGS):
        middle = (before + way) / 2
        x, y, z = start[0] + middle * a, start[1] + middle * b, start[2] + middle * c
        if _value(distance, x, y, z) > 0:
            before = middle
        else:
            way = middle
    return way


@njit(**INNER)
def _write_normal(distance, place, normal):
    x, y, z = place
    a = _value(distance, x + 1, y, z) - _value(distance, x - 1, y, z)
    b = _value(distance, x, y + 1, z) - _value(distance, x, y - 1, z)
    c = _value(distance, x, y, z + 1) - _value(distance, x, y, z - 1)
    size = max(np.sqrt(a * a + b * b + c * c), 1e-12)
    normal[0], normal[1], normal[2] = a / size, b / size, c / size


@njit(**INNER)
def _value(distance, x, y, z):
    """Return the distance between centres, linear along each axis; 0 beyond the outer centres."""
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    if min(i, j, k) < 0 or i + 1 >= distance.shape[0]:
        return 0.0
    if j + 1 >= distance.shape[1] or k + 1 >= distance.shape[2]:
        return 0.0
    x, y, z = x - i, y - j, z - k
    low = _plane(distance[i], j, k, y, z)
    high = _plane(distance[i + 1], j, k, y, z)
    return low + x * (high - low)


@njit(**INNER)
def _plane(plane, j, k, y, z):
    low = plane[j, k] + z * (plane[j, k + 1] - plane[j, k])
    high = plane[j + 1, k] + z * (plane[j + 1, k + 1] - plane[j + 1, k])
    return low + y * (high - low)
