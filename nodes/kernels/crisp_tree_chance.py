"""Random configurations of needles at their entry points, and turns between them.

Quaternions are w, x, y, z, from a needle's own axes to the patient's.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_options import INNER


class Region(NamedTuple):
    """Where configurations may be.

    axes : (n, 4) quaternions that turn e_z to the axes about which needles tilt.
    directions : (n, 3) those axes.
    heights : (n,) cosines of the largest tilts.
    shortest, longest : (n,) mm.
    """

    axes: np.ndarray
    directions: np.ndarray
    heights: np.ndarray
    shortest: np.ndarray
    longest: np.ndarray


@njit(**INNER)
def draw(chance):
    """Return a random number from 0 to below 1 [Steele2014]; chance : (1,) uint64, changed."""
    chance[0] += np.uint64(0x9E3779B97F4A7C15)
    z = chance[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return float(z >> np.uint64(11)) * 2.0**-53


@njit(**INNER)
def draw_configuration(chance, region, quaternions, lengths):
    """Write a configuration: tangents even over their cones, rolls and lengths even.

    Parameters
    ----------
    quaternions, lengths : (n, 4), (n,), written.
    """
    for needle in range(len(lengths)):
        height = 1.0 - draw(chance) * (1.0 - region.heights[needle])
        around, roll = 2.0 * np.pi * draw(chance), 2.0 * np.pi * draw(chance)
        half, tilt = 0.5 * roll, 0.5 * np.arccos(height)
        axis = np.cos(around) * np.sin(tilt), np.sin(around) * np.sin(tilt)
        tilted = multiply(region.axes[needle], (np.cos(tilt), axis[0], axis[1], 0.0))
        q = multiply(tilted, (np.cos(half), 0.0, 0.0, np.sin(half)))
        for part in range(4):
            quaternions[needle, part] = q[part]
        span = region.longest[needle] - region.shortest[needle]
        lengths[needle] = region.shortest[needle] + span * draw(chance)


@njit(**INNER)
def multiply(a, b):
    """Return the quaternion that turns by b and then by a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@njit(**INNER)
def turn_between(a, b):
    """Return the rotation vector, in patient axes, of the shortest turn from a to b."""
    w, x, y, z = multiply(b, (a[0], -a[1], -a[2], -a[3]))
    size = np.sqrt(x * x + y * y + z * z)
    if size == 0.0:
        return 0.0, 0.0, 0.0
    factor = 2.0 * np.arctan2(size, abs(w)) / (size if w >= 0.0 else -size)
    return factor * x, factor * y, factor * z


@njit(**INNER)
def turn_quaternion(turn, share):
    """Return the quaternion of a share of a rotation vector."""
    angle = share * np.sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2])
    factor = 0.5 * share if angle < 1e-9 else share * np.sin(0.5 * angle) / angle
    return np.cos(0.5 * angle), factor * turn[0], factor * turn[1], factor * turn[2]


@njit(**INNER)
def to_matrix(q):
    """Return a rotation matrix row by row."""
    w, x, y, z = q
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip
