"""Sine and cosine together, short enough for the compiler to interleave several of them."""

from math import factorial

import numpy as np
from numba import njit

from nodes.kernels.ctr_lanes import nearest, turn_quarters
from nodes.kernels.ctr_options import EXACT, INSIDE
from nodes.kernels.ctr_tuples import replace

TWO_OVER_PI = 2 / np.pi
HALF_PI_HIGH = round(np.pi / 2 * 2**32) / 2**32  # so short that 2^20 times it is exact
HALF_PI_LOW = np.pi / 2 - HALF_PI_HIGH + 6.123233995736766e-17  # what pi's nearest float lacks, too
# Taylor series about 0; on [-pi/4, pi/4] the first term left out is below 1e-16.
S3, S5, S7, S9, S11, S13, S15 = ((-1) ** (n // 2) / factorial(n) for n in range(3, 16, 2))
C2, C4, C6, C8, C10, C12, C14, C16 = ((-1) ** (n // 2) / factorial(n) for n in range(2, 17, 2))


@njit(**EXACT)
def sincos(angle):
    """Return sin and cos of an angle below 1e6 rad, to 2e-15: of a float or of lanes."""
    quarter = nearest(angle * TWO_OVER_PI)
    x = (angle - quarter * HALF_PI_HIGH) - quarter * HALF_PI_LOW
    z = x * x
    w = z * z  # two halves of each series run side by side
    odd = (S3 + z * S5) + w * ((S7 + z * S9) + w * ((S11 + z * S13) + w * S15))
    odd = x + x * z * odd
    even = (C4 + z * C6) + w * ((C8 + z * C10) + w * ((C12 + z * C14) + w * C16))
    even = 1.0 + z * (C2 + z * even)
    return turn_quarters(quarter, odd, even)


@njit(**INSIDE)
def all_sincos(angles):
    """Return the sines and the cosines of some angles."""
    sines, cosines = angles, angles
    for i in range(len(angles)):
        one, other = sincos(angles[i])
        sines, cosines = replace(sines, i, one), replace(cosines, i, other)
    return sines, cosines
