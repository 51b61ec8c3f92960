"""Whether an equilibrium is stable, and whether an insertion has one for every rotation.

With V the derivatives of the angles by those at the tips and M those of the bases' angles, the
energy is least where no det V vanishes between tip and entry and M V^-1, whose eigenvalues are
real, has none below 0. Then det M > 0; along a motion det M = 0 is where the robot snaps.
"""

from numba import njit
from numba.cpython.unsafe.tuple import tuple_setitem

from nodes.kernels.ctr_newton import at_bases, determinant, solve_columns
from nodes.kernels.ctr_options import INNER
from nodes.kernels.ctr_tuples import add, take, zeros_like

TERMS = 28  # of the power series over a section; exact to 1e-15 for wave numbers below 3 / length


@njit(**INNER)
def has_positive_ratio(size, over, under):
    """Return whether M V^-1 has positive eigenvalues only, by the invariants of the matrix.

    Parameters
    ----------
    over, under : states whose columns are M and V.
    """
    m = len(size)
    whole = determinant(size, under)
    if not whole > 0.0 or not determinant(size, over) > 0.0:
        return False
    trace, inverse_trace = 0.0, 0.0
    for column in range(m):
        # det of V with one column from M, summed, is det V tr(V^-1 M), which has the same trace.
        one, other = size, size
        for i in range(m):
            one = tuple_setitem(one, i, over[m + column * m + i])
            other = tuple_setitem(other, i, under[m + column * m + i])
        trace += solve_columns(size, under, one)[column]
        inverse_trace += solve_columns(size, over, other)[column]
    # The second invariant of a 3 x 3 matrix is its determinant times the trace of its inverse.
    return trace > 0.0 and (m < 3 or inverse_trace > 0.0)


@njit(**INNER)
def is_stable(size, columns, weights, betas, nodes, steps):
    """Return whether the configuration that the nodes hold is stable."""
    state = columns
    for node in range(1, steps + 1):
        state = take(columns, nodes.state, node, 0)
        if not determinant(size, state) > 0.0:
            return False
    state = take(columns, nodes.state, steps, 0)
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
            signs = tuple_setitem(signs, i, -1.0 if corner >> i & 1 else 1.0)
        det, fine = _corner(size, columns, weights, betas, signs, sections, count)
        least, stable = min(least, det), stable and fine
    return least, stable


@njit(**INNER)
def _corner(size, columns, weights, betas, signs, sections, count):
    m = len(size)
    state, rate, fine = zeros_like(columns), zeros_like(columns), True
    for i in range(m):
        state = tuple_setitem(state, m + i * m + i, 1.0)
    for k in range(count):
        h = sections.place[k + 1] - sections.place[k]
        if sections.coupled[k] and h < 0.0:
            share, drive = take(weights, sections.share, k, 0), take(weights, sections.drive, k, 0)
            state, rate = _oscillate(size, share, drive, signs, h, state, rate)
            fine = fine and determinant(size, state) > 0.0
        else:
            state = add(state, h, rate)
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
            out = tuple_setitem(out, column + i, pull + drive[0] * more)
    return out
