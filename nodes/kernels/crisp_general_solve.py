"""Base wrenches of any CRISP robot: damped Newton steps, then Broyden's [Broyden1965].

A step is judged by the correction that it leaves, not by the residual [Deuflhard2011] Sec. 3.3:
where a robot gives way easily, good steps raise the residual.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_general import new_walk, walk_robot
from nodes.kernels.crisp_general_units import (
    aim,
    balance_forces,
    copy,
    is_out_of_reach,
    set_weights,
    step_reach,
)
from nodes.kernels.crisp_linear import factorise, solve_factorised
from nodes.kernels.crisp_options import INNER, OUTER

SOLVED, NO_SOLUTION, NOT_CONVERGED, UNSTABLE = 0, 1, 2, 3  # as nodes.mechanics.shapes.Status
LIMIT = 30  # evaluations of the derivatives; a solve that converges takes fewer than ten
LEAST = 1 / 256  # share of a step below which there is no way on
CHORD = 0.5  # a step is shorter than the last by this share, or the derivatives are renewed
CHORDS = 10  # steps by the same derivatives at most
ROUGH = 1e-5  # how exactly the residual is integrated meanwhile, in its own size
TINY = 1e-300  # where nothing is left to do, against 0 / 0
FINER = 0.6  # the end is checked with steps of this share of the length


class Newton(NamedTuple):
    """Workspace of a solve.

    walk : of the evaluations.
    triangles, order : the factorised derivatives.
    weights : (6 n,) what turns each row of the residual into mm.
    units : (6 n,) wrenches that bend a rod as long as the tool by a radian.
    target : (6 n,) residual that is aimed at, 0 but on the way there.
    steps : (CHORDS + 1, 6 n) in units, since the derivatives were renewed; the last one not taken.
    trial : (n, 6).
    """

    walk: tuple
    triangles: np.ndarray
    order: np.ndarray
    weights: np.ndarray
    units: np.ndarray
    target: np.ndarray
    steps: np.ndarray
    trial: np.ndarray


@njit(**OUTER)
def new_newton(crisp):
    """Return a workspace for the rods of a robot."""
    n = len(crisp.soft)
    return Newton(
        new_walk(crisp, 6 * n),
        np.empty((6 * n, 6 * n)),
        np.empty(6 * n, np.int64),
        np.ones(6 * n),
        np.ones(6 * n),
        np.zeros(6 * n),
        np.empty((CHORDS + 1, 6 * n)),
        np.empty((n, 6)),
    )


@njit(**OUTER)
def solve_wrenches(crisp, wrench, tolerance, newton):
    """Improve a guess of the base wrenches until the residual is below the tolerance.

    Parameters
    ----------
    crisp : Packed.
    wrench : (n, 6) moment and force at the bases, changed in place.
    tolerance : mm; angles count by the tool's length, moments by the deflection that they make.
    newton : Newton.

    Returns
    -------
    Status, residual in mm, evaluations of the derivatives and of the residual alone.
    """
    if is_out_of_reach(crisp):
        return NO_SOLUTION, np.inf, 0, 0
    set_weights(crisp, newton)
    aim(newton, newton.target, 0.0)
    return iterate(crisp, wrench, tolerance, newton)


@njit(**INNER)
def iterate(crisp, wrench, tolerance, newton):
    """Newton's method with shortened steps, and Broyden's once a whole step gains."""
    balance_forces(crisp, wrench)
    reach, share, way, full, short, size = step_reach(crisp, tolerance), 1.0, np.inf, 0, 0, 1.0
    while full < LIMIT:
        size = measure_rows(crisp, wrench, _coarsen(crisp, reach, size), newton)
        full += 1
        copy(newton.walk.rows, newton.triangles)
        if not (size < np.inf and factorise(newton.triangles, newton.order)):
            break
        before, way = way, find_step(newton, np.int64(0))
        if share < 1.0:
            share = _foresee(newton, before, way, share)
        size, share, tries = _shorten(crisp, wrench, way, share, size, reach, tolerance, newton)
        short += tries
        if share < LEAST:
            break
        if share == 1.0:
            size, tries, checked = _chase(crisp, wrench, way, size, reach, tolerance, newton)
            short += tries
            if checked and size < tolerance:
                return SOLVED, size, full, short
            if checked:
                reach *= FINER
    return NOT_CONVERGED, size, full, short


@njit(**INNER)
def _coarsen(crisp, reach, size):
    """Return how far steps may turn as long as the residual is no smaller, rad."""
    return max(reach, step_reach(crisp, ROUGH * min(size, 1.0)))


@njit(**INNER)
def _foresee(newton, before, way, share):
    """Return what share of a step will do, from how much the last step's correction changed when
    the derivatives were renewed; `before` and `way` are the lengths of the last step and this."""
    total, left = 0.0, 0.0
    for i in range(newton.steps.shape[1]):
        left += newton.steps[1, i] ** 2
        total += (newton.steps[1, i] - newton.steps[0, i]) ** 2
    return min(1.0, share * before * np.sqrt(left) / (np.sqrt(total) * way + TINY))


@njit(**INNER)
def _shorten(crisp, wrench, way, share, size, reach, tolerance, newton):
    """Go the Newton step, shorter until what is left of it is shorter, too.

    Returns residual, the share that was gone, below LEAST if none helps, and the evaluations.
    """
    tries, share = 0, max(share, 2 * LEAST)
    reach = _coarsen(crisp, reach, size)
    while share >= LEAST:
        size = measure_step(crisp, wrench, np.int64(0), share, reach, newton)
        tries += 1
        left = find_step(newton, np.int64(1))
        if left <= (1 - 0.7 * share) * way or size < tolerance:
            copy(newton.trial, wrench)
            break
        bent = 0.0
        for i in range(newton.steps.shape[1]):
            bent += (newton.steps[1, i] - (1 - share) * newton.steps[0, i]) ** 2
        share *= min(0.5, 0.5 * share * way / np.sqrt(bent)) if bent < np.inf else 0.1
    return size, share, tries


@njit(**INNER)
def _chase(crisp, wrench, before, size, reach, tolerance, newton):
    """Go on from a whole Newton step by Broyden's while each is shorter than the last by CHORD.

    before, size : length of the Newton step, residual after it.

    Returns residual, evaluations, and whether the last was with finer steps: where next to nothing
    should be left, they show the integrator's error.
    """
    way, tries, checked = learn(newton, np.int64(1)), 0, False
    for count in range(1, CHORDS):
        if not (way < CHORD * before or size < tolerance):
            break
        ahead = size * min(way / (before + TINY), 1.0)
        checked = ahead < tolerance
        fine = FINER * reach if checked else _coarsen(crisp, reach, ahead)
        size = measure_step(crisp, wrench, count, 1.0, fine, newton)
        tries += 1
        if checked:
            if size < ROUGH:
                copy(newton.trial, wrench)
            break
        find_step(newton, count + 1)
        before, way = way, learn(newton, count + 1)
        if way < before:
            copy(newton.trial, wrench)
    return size, tries, checked


@njit(**INNER)
def find_step(newton, number):
    """Write, as step `number`, what the factorised derivatives make of the last residual; return
    its length."""
    step, total = newton.steps[number], 0.0
    for i in range(len(step)):
        step[i] = newton.target[i] - newton.walk.residual[i]
    solve_factorised(newton.triangles, newton.order, step)
    for i in range(len(step)):
        step[i] /= newton.units[i]
        total += step[i] ** 2
    return np.sqrt(total)


@njit(**INNER)
def learn(newton, number):
    """Turn a step by old derivatives into Broyden's, from the steps before it; return its length.

    The updates are never made: what they would add is a sum over those steps [Kelley2003] Ch. 4.
    """
    step = newton.steps[number]
    for past in range(number):
        last = newton.steps[past]
        across, along = 0.0, 0.0
        for i in range(len(step)):
            across += last[i] * step[i]
            along += last[i] ** 2
        share = across / (along + TINY)
        if past + 1 < number:
            for i in range(len(step)):
                step[i] += share * newton.steps[past + 1, i]
        elif share < 0.5:
            for i in range(len(step)):
                step[i] /= 1 - share
    total = 0.0
    for i in range(len(step)):
        total += step[i] ** 2
    return np.sqrt(total)


@njit(**INNER)
def measure_step(crisp, wrench, number, share, reach, newton):
    """Try a share of a step from `wrench`; return the residual, mm."""
    for rod in range(len(wrench)):
        for i in range(6):
            at = 6 * rod + i
            newton.trial[rod, i] = (
                wrench[rod, i] + share * newton.steps[number, at] * newton.units[at]
            )
    return measure(crisp, newton.trial, reach, newton)


@njit(**INNER)
def measure(crisp, wrench, reach, newton):
    """Evaluate the residual and return its size, mm."""
    walk_robot(crisp, wrench, reach, newton.walk, np.int64(0))
    return _size(newton)


@njit(**OUTER)
def measure_rows(crisp, wrench, reach, newton):
    """As `measure`, with derivatives by the base wrenches."""
    changes = newton.walk.changes
    for rod in range(len(wrench)):
        for i in range(12):
            for c in range(changes.shape[2]):
                changes[rod, i, c] = 0.0
        for i in range(6):
            changes[rod, 6 + i, 6 * rod + i] = 1.0
    walk_robot(crisp, wrench, reach, newton.walk, changes.shape[2])
    return _size(newton)


@njit(**INNER)
def _size(newton):
    total = 0.0
    for i in range(len(newton.weights)):
        total += (newton.weights[i] * (newton.walk.residual[i] - newton.target[i])) ** 2
    return np.sqrt(total)
