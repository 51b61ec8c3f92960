"""Whether an equilibrium is stable, and whether an insertion has one for every rotation.

With V the derivatives of the angles by those at the tips and M those of the bases' angles, the
energy is least where no det V vanishes between tip and entry and M V^-1, whose eigenvalues are
real, has none below 0. Then det M > 0; along a motion det M = 0 is where the robot snaps.
"""

from numba import njit

from nodes.kernels.ctr_newton import at_bases, determinant
from nodes.kernels.ctr_options import INNER
from nodes.kernels.ctr_tuples import add, replace, take, zeros_like

TERMS = 28  # of the power series over a cut; exact to 1e-15 for wave numbers below 3 / length
STEPS_A_CUT = 3  # of the integration, half a radian each: so a cut can't buckle between held ends


@njit(**INNER)
def has_positive_ratio(size, over, under):
    """Return whether M V^-1 has positive eigenvalues only, which are real.

    Then all coefficients of the polynomial det(M + x V) are positive, and only then.

    Parameters
    ----------
    over, under : states whose columns are M and V.
    """
    m = len(size)
    if not determinant(size, under) > 0.0 or not determinant(size, over) > 0.0:
        return False
    if m > 1 and not _mixed_determinant(size, under, over) > 0.0:
        return False
    return m < 3 or _mixed_determinant(size, over, under) > 0.0


@njit(**INNER)
def _mixed_determinant(size, state, other):
    """Return the derivative of det(state + x other) by x at 0."""
    m, total = len(size), 0.0
    for column in range(m, m + m * m, m):
        changed = state
        for i in range(column, column + m):
            changed = replace(changed, i, other[i])
        total += determinant(size, changed)
    return total


@njit(**INNER)
def is_stable(size, columns, weights, betas, nodes, steps):
    """Return whether the configuration that the nodes hold is stable.

    Signs of det V alone would miss two modes that are lost within one step. Over a step so short
    that it can't buckle between held ends, V(k+1) V(k)^-1 has a negative eigenvalue for each mode
    that is lost in it [Wittrick1971].
    """
    state = take(columns, nodes.state, 0, 0)
    for node in range(1, steps + 1):
        before, state = state, take(columns, nodes.state, node, 0)
        if not has_positive_ratio(size, state, before):
            return False
    rate = take(columns, nodes.rate, steps, 0)
    return has_positive_ratio(size, at_bases(weights, betas, state, rate), state)


@njit(**INNER)
def least_determinant(size, columns, weights, betas, sections, count):
    """Return the least det M over the corners where each tube is aligned or opposed to the
    innermost, and whether all of them are stable.

    There the angles stay as they are, the derivatives obey linear equations, and stability is
    lost first: for two tubes this is cos(w l) - w b sin(w l) > 0, and proven. For three and four a
    dense grid over all angles always agreed (3,000 random insertions of three tubes on 24 x 24,
    1,343 near the limit on 32 x 32, 450 of four tubes on 12 x 12 x 12), though det M itself may be
    a little smaller elsewhere.
    """
    least, stable = 1.0, True
    for corner in range(1, 2 ** len(size)):
        signs = size
        for i in range(len(size)):
            signs = replace(signs, i, -1.0 if corner >> i & 1 else 1.0)
        det, fine = _corner(size, columns, weights, betas, signs, sections, count)
        least, stable = min(least, det), stable and fine
    return least, stable


@njit(**INNER)
def _corner(size, columns, weights, betas, signs, sections, count):
    m = len(size)
    state, rate, fine = zeros_like(columns), zeros_like(columns), True
    for i in range(m):
        state = replace(state, m + i * m + i, 1.0)
    for k in range(count):
        h = sections.place[k + 1] - sections.place[k]
        if sections.coupled[k] and h < 0.0:
            share, drive = take(weights, sections.share, k, 0), take(weights, sections.drive, k, 0)
            cuts = (sections.steps[k] + STEPS_A_CUT - 1) // STEPS_A_CUT
            for _ in range(cuts):
                before = state
                state, rate = _oscillate(size, share, drive, signs, h / cuts, state, rate)
                fine = fine and has_positive_ratio(size, state, before)
        else:
            before, state = state, add(state, h, rate)
            fine = fine and has_positive_ratio(size, state, before)
    held = at_bases(weights, betas, state, rate)
    return determinant(size, held), fine and has_positive_ratio(size, held, state)


@njit(**INNER)
def _oscillate(size, share, drive, signs, h, state, rate):
    """Advance y'' = K y exactly by its power series; K belongs to angles of 0 (1) and pi (-1)."""
    even, odd = state, add(zeros_like(state), h, rate)
    total, slope = add(state, 1.0, odd), odd
    for n in range(0, TERMS, 2):
        one = _stiffness_times(size, share, drive, signs, even)
        other = _stiffness_times(size, share, drive, signs, odd)
        even = add(zeros_like(state), h * h / ((n + 1) * (n + 2)), one)
        odd = add(zeros_like(state), h * h / ((n + 2) * (n + 3)), other)
        total = add(add(total, 1.0, even), 1.0, odd)
        slope = add(add(slope, n + 2, even), n + 3, odd)
    return total, add(zeros_like(state), 1 / h, slope)


@njit(**INNER)
def _stiffness_times(size, share, drive, signs, state):
    m = len(size)
    out = state
    along = share[0]
    for i in range(m):
        along += share[i + 1] * signs[i]
    for column in range(0, len(state), m):
        more = 0.0
        for i in range(m):
            more += share[i + 1] * signs[i] * state[column + i]
        for i in range(m):
            pull = drive[i + 1] * signs[i] * (along * state[column + i] - more)
            out = replace(out, column + i, pull + drive[0] * more)
    return out
