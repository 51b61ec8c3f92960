"""Base wrenches of any CRISP robot without a guess near by: by following solutions to it."""

import numpy as np
from numba import njit

from nodes.kernels.crisp_general import advance, place_base
from nodes.kernels.crisp_general_problem import ARC, LENGTH, Packed
from nodes.kernels.crisp_general_solve import (
    NO_SOLUTION,
    NOT_CONVERGED,
    SOLVED,
    iterate,
    measure,
)
from nodes.kernels.crisp_general_units import (
    aim,
    balance_forces,
    copy,
    is_out_of_reach,
    set_weights,
    step_reach,
)
from nodes.kernels.crisp_options import INNER, OUTER

REST_REACH = 0.5  # rad, of a step along a tool at rest
FIRST, NARROW = 0.25, 1 / 512  # first and least share of the way that is taken at once
ROUGH = 1e-3  # mm, residual of the solutions on the way
NEAR = 6  # evaluations after which a solution may be another than the one that is followed
WAYS = 500  # evaluations of the derivatives on the way


@njit(**OUTER)
def solve_from_rest(crisp, wrench, seeds, tolerance, newton):
    """Solve without a guess; `wrench` (n, 6) is written.

    Tried in turn until one is solved: without loads, by Newton's method from the tubes at rest or
    by closing the joints' gaps in parts, then raising the loads; closing the gaps under the loads;
    closing them from each of `seeds` (s, n, 6), since a symmetric robot at rest cannot choose a
    side.

    Returns
    -------
    Status, residual in mm, evaluations of the derivatives and of the residual alone.
    """
    if is_out_of_reach(crisp):
        return NO_SOLUTION, np.inf, 0, 0
    set_weights(crisp, newton)
    status, size, full, short = _raise_loads(crisp, wrench, tolerance, newton)
    for way in range(-1, len(seeds)):
        if status == SOLVED:
            break
        if way < 0:
            rest_wrench(crisp, wrench, newton)
        else:
            copy(seeds[way], wrench)
        status, size, more, shorter = close_gap(crisp, wrench, tolerance, newton)
        full, short = full + more, short + shorter
    return status, size, full, short


@njit(**OUTER)
def close_gap(crisp, wrench, tolerance, newton):
    """Follow the solutions of residual = (1 - share) residual(start) from share 0 to 1."""
    reach = step_reach(crisp, tolerance)
    set_weights(crisp, newton)
    aim(newton, newton.target, 0.0)
    balance_forces(crisp, wrench)
    measure(crisp, wrench, reach, newton)
    gap, kept = newton.walk.residual.copy(), wrench.copy()
    share, stride, full, short = 0.0, FIRST, 0, 0
    while stride > NARROW and full < WAYS:
        then = min(1.0, share + stride)
        aim(newton, gap, 1 - then)
        wanted = tolerance if then == 1.0 else max(tolerance, ROUGH)
        status, size, more, shorter = iterate(crisp, wrench, wanted, newton)
        full, short = full + more, short + shorter
        if status == SOLVED and then == 1.0:
            return status, size, full, short
        if status == SOLVED:
            share, stride = then, 2 * stride
            copy(wrench, kept)
        else:
            stride *= 0.4
            copy(kept, wrench)
    aim(newton, gap, 0.0)
    return NOT_CONVERGED, measure(crisp, wrench, reach, newton), full, short


@njit(**INNER)
def _raise_loads(crisp, wrench, tolerance, newton):
    """Solve without the loads, then follow the solution while they grow."""
    stride = _first_share(crisp, wrench, newton)
    start = _with_loads(crisp, 0.0)
    rest_wrench(start, wrench, newton)
    aim(newton, newton.target, 0.0)
    status, size, full, short = iterate(start, wrench, tolerance, newton)
    if status != SOLVED:
        rest_wrench(start, wrench, newton)
        status, size, more, shorter = close_gap(start, wrench, tolerance, newton)
        full, short = full + more, short + shorter
    if status != SOLVED or len(crisp.loads) == 0:
        return status, size, full, short
    before, kept, guess = wrench.copy(), wrench.copy(), wrench.copy()
    past, share = 0.0, 0.0
    while stride > NARROW and full < WAYS:
        then = min(1.0, share + stride)
        ahead = (then - share) / (share - past) if share > past else 0.0
        for rod in range(len(wrench)):
            for i in range(6):
                guess[rod, i] = kept[rod, i] + ahead * (kept[rod, i] - before[rod, i])
        wanted = tolerance if then == 1.0 else max(tolerance, ROUGH)
        status, size, more, shorter = iterate(_with_loads(crisp, then), guess, wanted, newton)
        full, short = full + more, short + shorter
        if status == SOLVED and more <= NEAR:
            past, share, stride = share, then, 1.5 * stride
            copy(kept, before)
            copy(guess, kept)
            copy(guess, wrench)
            if then == 1.0:
                return status, size, full, short
        else:
            stride *= 0.4
    return NOT_CONVERGED, size, full, short


@njit(**INNER)
def _first_share(crisp, wrench, newton):
    """Return what share of the loads bends a straight tool by about half a radian."""
    rest_wrench(crisp, wrench, newton)
    bend = np.sqrt(wrench[0, 0] ** 2 + wrench[0, 1] ** 2 + wrench[0, 2] ** 2)
    bend *= crisp.bases[0, LENGTH] * crisp.soft[0, 0]
    return max(min(1.0, 0.5 / (bend + 1e-12)), 4 * NARROW)


@njit(**INNER)
def _with_loads(crisp, share):
    loads = crisp.loads.copy()
    for load in range(len(loads)):
        for i in range(1, 7):
            loads[load, i] *= share
    return Packed(crisp.soft, crisp.bases, crisp.joints, loads)


@njit(**INNER)
def rest_wrench(crisp, wrench, newton):
    """Write the wrenches of snares at rest and of a tool that bears its loads without bending."""
    walk = newton.walk
    for rod in range(len(wrench)):
        for i in range(6):
            wrench[rod, i], walk.acting[rod, i] = 0.0, 0.0
    balance_forces(crisp, wrench)
    place_base(crisp, 0, walk.tips[0])
    arc, tool = 0.0, np.int64(0)
    for load in range(len(crisp.loads)):
        advance(crisp.loads[load, ARC] - arc, tool, REST_REACH, walk, tool, tool)
        arc = crisp.loads[load, ARC]
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            arm_a = walk.tips[0, a] - crisp.bases[0, a]
            arm_b = walk.tips[0, b] - crisp.bases[0, b]
            turned = arm_a * crisp.loads[load, 4 + b] - arm_b * crisp.loads[load, 4 + a]
            wrench[0, i] += crisp.loads[load, 1 + i] + turned
