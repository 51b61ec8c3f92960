"""Rotations as tuples of nine floats by rows, vectors as tuples of three."""

from math import factorial

from numba import njit

from nodes.kernels.ctr_options import INSIDE

# (z - sin)/z^3 and (1/2 - (1 - cos)/z^2)/z^2 in powers of z^2: exact to 1e-15 below 2.5 rad.
ODD = tuple((-1) ** k / factorial(2 * k + 3) for k in range(11))
EVEN = tuple((-1) ** k / factorial(2 * k + 4) for k in range(11))


@njit(**INSIDE)
def cross(a, b):
    """Return the cross product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(**INSIDE)
def rotate(r, v):
    """Return the rotated vector."""
    return (
        r[0] * v[0] + r[1] * v[1] + r[2] * v[2],
        r[3] * v[0] + r[4] * v[1] + r[5] * v[2],
        r[6] * v[0] + r[7] * v[1] + r[8] * v[2],
    )


@njit(**INSIDE)
def multiply(a, b):
    """Return the product of two rotations."""
    x = rotate(a, (b[0], b[3], b[6]))
    y = rotate(a, (b[1], b[4], b[7]))
    z = rotate(a, (b[2], b[5], b[8]))
    return x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]


@njit(**INSIDE)
def turn(r, sine, cosine):
    """Return r times a rotation about z."""
    return (
        r[0] * cosine + r[1] * sine, r[1] * cosine - r[0] * sine, r[2],
        r[3] * cosine + r[4] * sine, r[4] * cosine - r[3] * sine, r[5],
        r[6] * cosine + r[7] * sine, r[7] * cosine - r[6] * sine, r[8],
    )  # fmt: skip


@njit(**INSIDE)
def _series(c, z):
    """Return the sum of c_k z^k; quarters of it run side by side."""
    w = z * z
    low = (c[0] + z * c[1]) + w * (c[2] + z * c[3])
    high = (c[4] + z * c[5]) + w * (c[6] + z * c[7])
    top = (c[8] + z * c[9]) + w * c[10]
    square = w * w
    return low + square * (high + square * top)


@njit(**INSIDE)
def move(w, v):
    """Return rotation and translation of the exponential of the twist (w, v), |w| below 2.5 rad."""
    z = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    c, d = _series(ODD, z), _series(EVEN, z)
    a, b = 1.0 - z * c, 0.5 - z * d
    xx, yy, zz = w[0] * w[0], w[1] * w[1], w[2] * w[2]
    xy, xz, yz = b * w[0] * w[1], b * w[0] * w[2], b * w[1] * w[2]
    rotation = (
        1.0 - b * (yy + zz), xy - a * w[2], xz + a * w[1],
        xy + a * w[2], 1.0 - b * (xx + zz), yz - a * w[0],
        xz - a * w[1], yz + a * w[0], 1.0 - b * (xx + yy),
    )  # fmt: skip
    once = cross(w, v)
    twice = cross(w, once)
    translation = (
        v[0] + b * once[0] + c * twice[0],
        v[1] + b * once[1] + c * twice[1],
        v[2] + b * once[2] + c * twice[2],
    )
    return rotation, translation
