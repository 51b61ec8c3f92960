"""Solve concentric tube robots, configuration after configuration, with scratch made once."""

import numpy as np
from numba import njit

from nodes.kernels.ctr_approach import approach_group, clear, pack
from nodes.kernels.ctr_continuation import follow
from nodes.kernels.ctr_frames import place_frames
from nodes.kernels.ctr_jacobian import tip_jacobian
from nodes.kernels.ctr_lanes import LANES, store_rows
from nodes.kernels.ctr_newton import approach, at_bases, settle, start_columns
from nodes.kernels.ctr_options import INNER, OUTER
from nodes.kernels.ctr_outcomes import (
    borrow_joints,
    borrow_outcomes,
    borrow_scratch,
    borrow_tubes,
    sections_of,
)
from nodes.kernels.ctr_rotations import turn
from nodes.kernels.ctr_samples import sample_points
from nodes.kernels.ctr_sections import cut_sections
from nodes.kernels.ctr_sincos import sincos
from nodes.kernels.ctr_stability import is_stable, least_determinant
from nodes.kernels.ctr_torsion import untwist_coarsely
from nodes.kernels.ctr_tuples import prepend, put, replace, take, zeros_like

SOLVED, NO_SOLUTION, NOT_CONVERGED, UNSTABLE = 0, 1, 2, 3
# Longest step, rad: wave number times length, and curvature times length. The polynomials of degree
# 9 and Magnus' series then keep 3e-7 mm; the Jacobian's integrals want shorter ones for 1e-6.
FOR_SHAPE, FOR_JACOBIAN = (0.5, 1.2), (0.5, 0.8)
# rad; so short a Newton step is applied linearly: its square is below 1e-9 rad. Derivatives are
# kept from before it, so they want a shorter one.
END_FOR_SHAPE, END_FOR_JACOBIAN = 2e-5, 3e-6
MOST_TURN = 1e6  # rad; of larger rotations too few digits are left
ROUNDING = 1e-9  # mm by which bases and tips may be out of order
FEW = 9  # starts along each angle where no way from aligned tubes was found


@njit(**OUTER)
def solve_rows(size, columns, tubes, joints, first, last, scratch, outcomes):
    """Solve configurations first to last - 1.

    Parameters
    ----------
    size, columns : tuples of m and m + m m floats; m is one less than the tubes.
    tubes : Tubes.
    joints : Joints.
    scratch : Scratch.
    outcomes : Outcomes, written.
    """
    tubes, joints = borrow_tubes(tubes), borrow_joints(joints)
    scratch, outcomes = borrow_scratch(scratch), borrow_outcomes(outcomes)
    weights = weights_of(size, tubes)
    for start in range(first, last, LANES):
        stop = min(start + LANES, last)
        _begin(size, columns, weights, tubes, joints, start, stop, scratch, outcomes)
        for row in range(start, stop):
            lane = row - start
            if scratch.counts[lane] < 0:
                outcomes.status[row] = NO_SOLUTION
                _write_nothing(row, outcomes)
            else:
                _solve_row(size, columns, weights, tubes, joints, row, lane, scratch, outcomes)


@njit(**INNER)
def _begin(size, columns, weights, tubes, joints, start, stop, scratch, outcomes):
    """Cut up to eight configurations into sections and find where to start, one a lane."""
    group, counts, blocks = scratch.group, scratch.counts, 0
    cold = joints.start.shape[0] == 0
    limits, _ = _exactness(outcomes)
    if cold:
        clear(group)
    for lane in range(stop - start):
        row, counts[lane] = start + lane, -1
        if _is_possible(tubes, joints, row):
            sections = sections_of(scratch, lane)
            count = cut_sections(tubes, joints.translations, row, limits, sections)
            counts[lane] = count
            if cold:
                betas = take(weights, joints.translations, row, 0)
                target = _unwind(_between(size, joints.rotations, row))
                own = pack(size, lane, target, betas, sections, count, group)
                blocks = max(blocks, own)
    if cold:
        store_rows(approach_group(size, columns, weights, blocks, group), group, 0)


@njit(**INNER)
def _exactness(outcomes):
    """Return the longest steps and the end of Newton's method."""
    if outcomes.jacobian.shape[0] > 0:
        return FOR_JACOBIAN, END_FOR_JACOBIAN
    return FOR_SHAPE, END_FOR_SHAPE


@njit(**INNER)
def _solve_row(size, columns, weights, tubes, joints, row, lane, scratch, outcomes):
    sections, nodes, count = sections_of(scratch, lane), scratch.nodes, scratch.counts[lane]
    limits, end = _exactness(outcomes)
    betas = take(weights, joints.translations, row, 0)
    if outcomes.least.shape[0] > 0:
        least, every = least_determinant(size, columns, weights, betas, sections, count)
        outcomes.least[row] = least if every else min(least, 0.0)
    target, cold = _between(size, joints.rotations, row), joints.start.shape[0] == 0
    x = _between(size, joints.start, row) if not cold else size
    if cold:
        target = _unwind(target)
        for i in range(len(size)):
            x = replace(x, i, scratch.group[i, lane])
    x, settled, residual, det, steps = settle(
        size, columns, weights, betas, target, x, end, sections, count, nodes
    )
    stable = settled and is_stable(size, columns, weights, betas, nodes, steps)
    if cold and not stable:
        x = rescue(size, columns, weights, tubes, target, joints, row, limits, sections, scratch)
        x, settled, residual, det, steps = settle(
            size, columns, weights, betas, target, x, end, sections, count, nodes
        )
        stable = settled and is_stable(size, columns, weights, betas, nodes, steps)
    outcomes.status[row] = SOLVED if stable else UNSTABLE if settled else NOT_CONVERGED
    if not settled:
        _write_nothing(row, outcomes)
        return
    outcomes.residual[row], outcomes.determinant[row] = residual, det
    entry, tip = place_frames(
        size, weights, betas[0], joints.rotations[row, 0], tubes.base, sections, nodes, steps
    )
    _write(size, weights, joints, row, entry, tip, steps, nodes, outcomes)
    if outcomes.points.shape[0] > 0:
        sample_points(nodes, steps, row, outcomes.places, outcomes.points)
    if outcomes.jacobian.shape[0] > 0:
        tip_jacobian(
            size, columns, weights, betas, x, row, tubes.base, sections, count, nodes, steps,
            scratch.twists, outcomes.jacobian,
        )  # fmt: skip


@njit(**INNER)
def _write_nothing(row, o):
    if o.status[row] == NO_SOLUTION and o.least.shape[0] > 0:
        o.least[row] = np.nan
    o.determinant[row] = o.residual[row] = np.nan
    o.tips[row], o.entries[row], o.twists[row], o.frame[row] = np.nan, np.nan, np.nan, np.nan
    if o.points.shape[0] > 0:
        o.places[row], o.points[row] = np.nan, np.nan
    if o.jacobian.shape[0] > 0:
        o.jacobian[row] = np.nan


@njit(**INNER)
def _is_possible(tubes, joints, row):
    """Return whether joint values are finite and bases and tips in order, but for rounding."""
    n = tubes.length.shape[0]
    base, tip, fine = 0.0, 0.0, True
    for i in range(n - 1, -1, -1):
        beta = joints.translations[row, i]
        fine = fine and abs(joints.rotations[row, i]) < MOST_TURN and beta <= base + ROUNDING
        fine = fine and beta + tubes.length[i] >= tip - ROUNDING
        base, tip = beta, beta + tubes.length[i]
    return fine


@njit(**INNER)
def weights_of(size, tubes):
    """Return the tubes' shares of torsional stiffness."""
    weights = prepend(0.0, size)
    for i in range(len(weights)):
        weights = replace(weights, i, tubes.weight[i])
    return weights


@njit(**INNER)
def _between(size, angles, row):
    """Return the angles of the outer tubes to the innermost."""
    for i in range(len(size)):
        size = replace(size, i, angles[row, i + 1] - angles[row, 0])
    return size


@njit(**INNER)
def _unwind(angles):
    """Return the angles without whole turns."""
    for i in range(len(angles)):
        whole = 2 * np.pi * np.rint(angles[i] / (2 * np.pi))
        angles = replace(angles, i, angles[i] - whole)
    return angles


@njit(**INNER)
def rescue(size, columns, weights, tubes, target, joints, row, limits, sections, scratch):
    """Return tip angles of a stable configuration: followed from aligned tubes, or if the robot
    snaps on that way, from starts all around."""
    rotations, translations = scratch.rotations, scratch.translations
    nodes = scratch.nodes
    for i in range(len(weights)):
        rotations[0, i] = 0.0
        rotations[1, i] = target[i - 1] if i > 0 else 0.0
        translations[0, i] = translations[1, i] = joints.translations[row, i]
    x, share, _ = follow(
        size, columns, weights, tubes, rotations, translations, zeros_like(size), limits, sections,
        nodes,
    )  # fmt: skip
    start, found = 0, share == 1.0
    betas = take(weights, joints.translations, row, 0)
    while not found and start < FEW ** len(size):
        for i in range(len(size)):
            around = start // FEW**i % FEW
            x = replace(x, i, 2 * np.pi / FEW * (around - FEW // 2))
        count = cut_sections(tubes, joints.translations, row, limits, sections)
        x = _turn_near(size, columns, weights, betas, target, x, sections, count)
        x = approach(size, columns, weights, betas, target, x, sections, count)
        y, settled, _, _, steps = settle(
            size, columns, weights, betas, target, x, END_FOR_SHAPE, sections, count, nodes
        )
        found = settled and is_stable(size, columns, weights, betas, nodes, steps)
        x, start = y, start + 1
    return x


@njit(**INNER)
def _turn_near(size, columns, weights, betas, target, x, sections, count):
    """Return the tip angles with whole turns that bring those at the bases within half a turn."""
    state = start_columns(size, x, columns)
    state, rate = untwist_coarsely(size, weights, sections, count, state, zeros_like(columns))
    held = at_bases(weights, betas, state, rate)
    for i in range(len(size)):
        x = replace(x, i, x[i] + 2 * np.pi * np.rint((target[i] - held[i]) / (2 * np.pi)))
    return x


@njit(**INNER)
def _write(size, weights, joints, row, entry, tip, steps, nodes, outcomes):
    first = 0.0
    for i in range(len(size)):
        first -= weights[i + 1] * nodes.rate[steps, i]
    outcomes.tips[row, 0], outcomes.entries[row, 0], outcomes.twists[row, 0] = tip, entry, first
    for i in range(len(size)):
        twist = first + nodes.rate[steps, i]
        here = entry + nodes.state[steps, i]
        # Whole turns that were taken off to find the solution belong to tip and entry alike.
        asked = joints.rotations[row, i + 1] - joints.translations[row, i + 1] * twist
        whole = 2 * np.pi * np.rint((asked - here) / (2 * np.pi))
        outcomes.tips[row, i + 1] = tip + nodes.state[0, i] + whole
        outcomes.entries[row, i + 1], outcomes.twists[row, i + 1] = here + whole, twist
    sine, cosine = sincos(tip)
    frame = turn(take((0.0,) * 9, nodes.frame, 0, 0), -sine, cosine)
    put(frame, outcomes.frame, row, 0)
    for axis in range(3):
        outcomes.frame[row, 9 + axis] = nodes.frame[0, 9 + axis]
