"""What a joint demands of the tool and the snare that grasps it, six numbers, zero where it holds.

Rows 0 to 2: places, snare minus tool, mm. Rigid [Kuntz2017] eq. (6), rows 3 to 5: rotation vector
from the axes that the snare should have to those it has, so that only the true joint and not its
mirror at 180 degrees is a root. Relaxed [Anderson2017] eq. (6), (16): cosine of the angle between
the tangents minus the wanted one, and the moment about the snare's and about the tool's tangent.
"""

import numpy as np
from numba import njit

from nodes.kernels.crisp_options import INNER, OUTER

SMALL_ANGLE = 1e-4  # below this the series is exact to rounding


@njit(**OUTER)
def joint_residual(tool, snare, moment, rigid, cosine, out):
    """Write the six numbers.

    Parameters
    ----------
    tool, snare : (>= 12,) place and axes d1, d2, d3 of the tool at the joint, of the snare's tip.
    moment : (3,) what the tool exerts on the snare's tip, N mm.
    rigid, cosine : kind of the joint and wanted cosine between the tangents.
    """
    for i in range(3):
        out[i] = snare[i] - tool[i]
    if rigid:
        turn_between(tool, snare, out)
        return
    out[3], out[4], out[5] = -cosine, 0.0, 0.0
    for i in range(3):
        out[3] += tool[9 + i] * snare[9 + i]
        out[4] += snare[9 + i] * moment[i]
        out[5] += tool[9 + i] * moment[i]


@njit(**INNER)
def turn_between(tool, snare, out):
    """Write into out[3:6] the rotation vector of E = R_k R_x R_t^T, in world axes."""
    # R_k R_x = [d1, -d3, d2] of the snare stands beside [d1, d2, d3] of the tool.
    ax, ay, az, trace = 0.0, 0.0, 0.0, 0.0
    for own, other, sign in ((3, 3, 1.0), (6, 9, -1.0), (9, 6, 1.0)):
        tx, ty, tz = tool[own], tool[own + 1], tool[own + 2]
        kx, ky, kz = sign * snare[other], sign * snare[other + 1], sign * snare[other + 2]
        ax += ty * kz - tz * ky
        ay += tz * kx - tx * kz
        az += tx * ky - ty * kx
        trace += tx * kx + ty * ky + tz * kz
    sine = 0.5 * np.sqrt(ax * ax + ay * ay + az * az)
    scale = (
        0.5
        if sine < SMALL_ANGLE and trace > 1
        else 0.5 * np.arctan2(sine, 0.5 * (trace - 1)) / max(sine, 1e-300)
    )
    out[3], out[4], out[5] = scale * ax, scale * ay, scale * az


@njit(**OUTER)
def joint_rows(tool, snare, moment, rigid, residual, blocks):
    """Write the derivative of the last three numbers by small changes, world axes.

    blocks : (3, 3, 3) for the rotation vectors of tool and snare and for the moment.
    """
    if rigid:
        _turn_rows(residual[3:6], blocks)
        return
    t, k = tool[9:12], snare[9:12]
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        across = t[a] * k[b] - t[b] * k[a]
        blocks[0, 0, i], blocks[1, 0, i], blocks[2, 0, i] = across, -across, 0.0
        blocks[0, 1, i] = 0.0
        blocks[1, 1, i] = k[a] * moment[b] - k[b] * moment[a]
        blocks[2, 1, i] = k[i]
        blocks[0, 2, i] = t[a] * moment[b] - t[b] * moment[a]
        blocks[1, 2, i] = 0.0
        blocks[2, 2, i] = t[i]


@njit(**INNER)
def _turn_rows(turn, blocks):
    """Write d rho = J^-1(rho) d phi_snare - J^-T(rho) d phi_tool, J the left Jacobian of SO(3)."""
    squared = turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2
    angle = np.sqrt(squared)
    bend = 1 / 12
    if angle > 1e-2:  # the series' next term is below 1e-7 there
        bend = (1 - 0.5 * angle / np.tan(0.5 * angle)) / squared
    else:
        bend += squared / 720
    for i in range(3):
        for j in range(3):
            even = bend * turn[i] * turn[j] + ((1 - bend * squared) if i == j else 0.0)
            odd = 0.0
            if i != j:  # minus half of the cross-product matrix
                sign = 1.0 if (j - i) % 3 == 1 else -1.0
                odd = 0.5 * sign * turn[3 - i - j]
            blocks[1, i, j] = even + odd
            blocks[0, i, j] = -(even - odd)
            blocks[2, i, j] = 0.0
