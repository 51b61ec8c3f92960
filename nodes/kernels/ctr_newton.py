"""Newton's method for the angles at the tips that belong to given joint values.

Every choice of angles at the tips gives one robot, so the unknowns are single-valued; the joint
values that it belongs to are compared with the wanted ones [Rucker2010].
"""

import numpy as np
from numba import njit

from nodes.kernels.ctr_options import INNER
from nodes.kernels.ctr_torsion import untwist, untwist_coarsely
from nodes.kernels.ctr_tuples import add, replace, zeros_like

COARSE_LIMIT, FINE_LIMIT = 12, 8  # iterations
COARSE_END = 2e-3  # rad; the next, exact iteration starts here
LONGEST = 1.0  # rad, one update


@njit(**INNER)
def at_bases(weights, betas, state, rate):
    """Return the angles at the bases to that of the innermost tube, and their derivatives.

    theta_i - theta_1 = phi_i + beta_i u_i - beta_1 u_1 with u_i = phi_i' + u_1 and
    sum_i GJ_i u_i = 0: behind the entry tubes are straight and twist evenly.
    """
    m = len(weights) - 1
    angles = state
    for column in range(0, len(state), m):
        first = -weights[1] * rate[column]
        for i in range(1, m):
            first -= weights[i + 1] * rate[column + i]
        for i in range(m):
            twist = betas[i + 1] * (rate[column + i] + first) - betas[0] * first
            angles = replace(angles, column + i, state[column + i] + twist)
    return angles


@njit(**INNER)
def determinant(size, state):
    """Return the determinant of the columns behind the angles."""
    m = len(size)
    if len(size) == 1:
        return state[1]
    if len(size) == 2:
        return state[2] * state[5] - state[3] * state[4]
    return (
        state[m] * (state[2 * m + 1] * state[3 * m + 2] - state[2 * m + 2] * state[3 * m + 1])
        + state[m + 1] * (state[2 * m + 2] * state[3 * m] - state[2 * m] * state[3 * m + 2])
        + state[m + 2] * (state[2 * m] * state[3 * m + 1] - state[2 * m + 1] * state[3 * m])
    )


@njit(**INNER)
def solve_columns(size, state, right):
    """Return x with columns x = right by Cramer's rule."""
    m = len(size)
    whole = determinant(size, state)
    x = size
    for i in range(m):
        changed = state
        for k in range(m):
            changed = replace(changed, m + i * m + k, right[k])
        x = replace(x, i, determinant(size, changed) / whole)
    return x


@njit(**INNER)
def start_columns(size, angles, columns):
    """Return a state at the tip: the angles, and columns of the unit matrix."""
    m = len(size)
    state = zeros_like(columns)
    for i in range(m):
        state = replace(state, i, angles[i])
        state = replace(state, m + i * m + i, 1.0)
    return state


@njit(**INNER)
def shorten(step):
    """Return the step, shortened to the longest that is allowed, and its length."""
    length = 0.0
    for i in range(len(step)):
        length = max(length, abs(step[i]))
    share = min(1.0, LONGEST / length) if length > 0.0 else 1.0
    return add(zeros_like(step), share, step), length


@njit(**INNER)
def update(size, weights, betas, target, state, rate):
    """Return the Newton step in the angles at the tips, its length and the largest residual."""
    held = at_bases(weights, betas, state, rate)
    right, residual = size, 0.0
    for i in range(len(size)):
        right = replace(right, i, target[i] - held[i])
        residual = max(residual, abs(right[i]))
    step, length = shorten(solve_columns(size, held, right))
    return step, length, residual, determinant(size, held)


@njit(**INNER)
def approach(size, columns, weights, betas, target, x, sections, count):
    """Return angles at the tips after coarse Newton steps."""
    for _ in range(COARSE_LIMIT):
        state = start_columns(size, x, columns)
        state, rate = untwist_coarsely(size, weights, sections, count, state, zeros_like(columns))
        step, length, _, _ = update(size, weights, betas, target, state, rate)
        x = add(x, 1.0, step)
        if length < COARSE_END:
            break
    return x


@njit(**INNER)
def settle(size, columns, weights, betas, target, x, end, sections, count, nodes):
    """Return angles at the tips after exact Newton steps, the last of them applied linearly.

    Parameters
    ----------
    end : rad, how short that is.

    Returns
    -------
    x, whether they have settled, residual before the last step rad, determinant, steps.
    """
    residual, det, steps = np.inf, np.nan, 0
    for _ in range(FINE_LIMIT):
        state = start_columns(size, x, columns)
        state, rate, steps = untwist(
            size, weights, sections, count, state, zeros_like(columns), nodes
        )
        step, length, residual, det = update(size, weights, betas, target, state, rate)
        x = add(x, 1.0, step)
        if length < end:
            _apply(size, step, steps, nodes)
            return x, True, residual, det, steps
        if not length < np.inf:
            break
    return x, False, residual, det, steps


@njit(**INNER)
def _apply(size, step, steps, nodes):
    m = len(size)
    for node in range(steps + 1):
        for i in range(m):
            angle, rate = 0.0, 0.0
            for j in range(m):
                angle += nodes.state[node, m + j * m + i] * step[j]
                rate += nodes.rate[node, m + j * m + i] * step[j]
            nodes.state[node, i] += angle
            nodes.rate[node, i] += rate
