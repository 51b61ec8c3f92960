"""Tip Jacobian by all joint values.

Tips turn so that bases stay where the joint values hold them; `ctr_twists` says how the tip moves
with that, and here the angles' own derivatives by the translations are found.
"""

from numba import njit

from nodes.kernels.ctr_newton import at_bases, solve_columns
from nodes.kernels.ctr_options import INNER
from nodes.kernels.ctr_rotations import cross
from nodes.kernels.ctr_torsion import accelerate, step_order_8
from nodes.kernels.ctr_tuples import add, put, replace, take, zeros_like
from nodes.kernels.ctr_twists import integrate_twists


@njit(**INNER)
def untwist_shifted(size, columns, shares, x, sections, count, nodes):
    """Write `nodes.shift`: derivatives of the angles by the translations of the outer tubes.

    A break that moves towards the tip by d gives the rates below it (psi''_above - psi''_below) d.
    Steps are those of `untwist`; x are the angles at the tips.
    """
    state, rate, above = zeros_like(columns), zeros_like(columns), zeros_like(columns)
    for i in range(len(size)):
        state = replace(state, i, x[i])
    node = 0
    put(state, nodes.shift, 0, 0)
    for k in range(count):
        share, drive = take(shares, sections.share, k, 0), take(shares, sections.drive, k, 0)
        below = zeros_like(columns)
        if sections.coupled[k]:
            below = accelerate(size, share, drive, state)
        owner = sections.owner[k, 0]
        if owner > 0:
            rate = _jump(size, owner, above, below, rate)
        length = sections.place[k] - sections.place[k + 1]
        steps = sections.steps[k] if length > 0.0 else 0
        for _ in range(steps):
            put(rate, nodes.shift_rate, node, 0)
            if sections.coupled[k]:
                state, rate = step_order_8(size, share, drive, -length / steps, state, rate)
            else:
                state = add(state, -length / steps, rate)
            put(rate, nodes.shift_end, node, 0)
            node += 1
            put(state, nodes.shift, node, 0)
        above = below
        if sections.coupled[k] and length > 0.0:
            above = accelerate(size, share, drive, state)
    return state, rate, above


@njit(**INNER)
def _jump(size, owner, above, below, rate):
    m = len(size)
    for i in range(m):
        at = owner * m + i
        rate = replace(rate, at, rate[at] + above[i] - below[i])
    return rate


@njit(**INNER)
def tip_jacobian(
    size, columns, weights, betas, x, row, frame, sections, count, nodes, steps, work, out
):
    """Write the tip Jacobian of the configuration that the nodes hold, frames placed.

    Where breaks coincide, the derivative is that of the order in which `cut_sections` lists them.

    Parameters
    ----------
    x : angles of the tips to the innermost.
    frame : (12,) of the entry by rows, then its place mm.
    work : (2 m + 1, 6) scratch.
    out : (k, 6, 2 n) written: place, rotation vector; by rotations, then translations.
    """
    m = len(size)
    state, rate, bent = untwist_shifted(size, columns, weights, x, sections, count, nodes)
    integrate_twists(size, weights, frame, sections, count, nodes, steps, work)
    base, base_rate = take(columns, nodes.state, steps, 0), take(columns, nodes.rate, steps, 0)
    held = at_bases(weights, betas, base, base_rate)
    moved = at_bases(weights, betas, state, rate)
    first, back, backwards = 0.0, size, size
    for i in range(m):
        first -= weights[i + 1] * rate[i]
        back = replace(back, i, -rate[i])
        backwards = replace(backwards, i, -bent[i])
    own = at_bases(weights, betas, back, backwards)  # all tubes pushed out together ...
    own_spin = _spin(weights, betas, 0, back, backwards) - first
    for c in range(m):
        for i in range(m):
            own = replace(own, i, own[i] - moved[m + c * m + i])  # ... but not the outer ones
        for i in range(6):
            work[2 * m, i] -= work[m + c, i]
        own_spin -= _spin(weights, betas, m + c * m, state, rate)
    for i in range(m):
        own = replace(own, i, own[i] - first)
        at = m + i * m + i
        moved = replace(moved, at, moved[at] + rate[i] + first)
    for c in range(m):
        right = size
        for i in range(m):
            right = replace(right, i, 1.0 if i == c else 0.0)
        _write_joint(size, weights, betas, held, right, 0.0, -1, base, base_rate, row, c + 1, nodes,
                     frame, work, out)  # fmt: skip
        for i in range(m):
            right = replace(right, i, -moved[m + c * m + i])
        spin = _spin(weights, betas, m + c * m, state, rate)
        _write_joint(size, weights, betas, held, right, spin, m + c, base, base_rate, row,
                     m + 2 + c, nodes, frame, work, out)  # fmt: skip
    right, less = size, size
    for i in range(m):
        right, less = replace(right, i, -1.0), replace(less, i, -own[i])
    _write_joint(size, weights, betas, held, right, 1.0, -1, base, base_rate, row, 0, nodes, frame,
                 work, out)  # fmt: skip
    _write_joint(size, weights, betas, held, less, own_spin, 2 * m, base, base_rate, row, m + 1,
                 nodes, frame, work, out)  # fmt: skip


@njit(**INNER)
def _spin(weights, betas, column, state, rate):
    """Return how far the whole robot turns for the innermost base to stay: the tubes' mean angle is
    theta_1 + sum_i w_i (phi_i + beta_1 phi_i')."""
    total = 0.0
    for i in range(len(weights) - 1):
        total += weights[i + 1] * (state[column + i] + betas[0] * rate[column + i])
    return total


@njit(**INNER)
def _write_joint(
    size,
    weights,
    betas,
    held,
    right,
    spin,
    direct,
    state,
    rate,
    row,
    joint,
    nodes,
    frame,
    work,
    out,
):
    """Write a column: what the joint does itself, by turning tips so that bases stay, by spin."""
    m = len(size)
    tips = solve_columns(size, held, right)
    for c in range(m):
        spin += tips[c] * _spin(weights, betas, m + c * m, state, rate)
    for i in range(6):
        total = work[direct, i] if direct >= 0 else 0.0
        for c in range(m):
            total += tips[c] * work[c, i]
        out[row, i, joint] = total
    # The frame is carried from the base without twist, so that spin turns it by e3 - t alone.
    t = (nodes.frame[0, 2], nodes.frame[0, 5], nodes.frame[0, 8])
    axis = (frame[2], frame[5], frame[8])
    arm = (
        nodes.frame[0, 9] - frame[9],
        nodes.frame[0, 10] - frame[10],
        nodes.frame[0, 11] - frame[11],
    )
    moved = cross(axis, arm)
    for i in range(3):
        out[row, i, joint] += spin * moved[i]
        out[row, 3 + i, joint] += spin * (axis[i] - t[i])
