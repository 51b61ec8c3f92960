"""Solve for the wrenches of straight CRISP robots in lanes: Newton, and Broyden's update between.

Broyden's update [Broyden1965] keeps an inverse Jacobian right along the directions that iterations
take, so that along an edge of small steps few Jacobians are needed. Lanes that are done, or that
do not get better, stand still while others go on.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_lanes import absolute, choose, is_any, is_less, load, spread, store
from nodes.kernels.crisp_straight_inverse import renew_inverse
from nodes.kernels.crisp_straight_residual import find_residual

WEIGHT_OF_CHANGE = 0.1  # of the change that is still asked for, in how wrong the wrenches are
HALVINGS = 4  # of a change that makes it worse, where each iteration has its own Jacobian
PATIENCE = 5  # iterations within which the residual halves, or else it never will
_TINY = 1e-30  # below it a change of the residual tells nothing of the Jacobian


class Solver(NamedTuple):
    """What iterations carry along; all arrays have LANES columns.

    residual, before, change, offset : (6 k,) now, one iteration before, last change of the
        wrenches, and what the residual shall be.
    guess : (6 k,) wrenches at which a step begins.
    checked : (6 k,) wrenches for which numbers of steps were measured.
    inverse : (36 k^2,) of the Jacobian, row by row.
    jacobian, columns, moves : (36 k^2,), (36,), (36 k,) for `find_jacobian`.
    totals : (PATIENCE,) magnitudes of the last residuals.
    product : (36 k^2,) of Jacobian and inverse.
    signs : (LANES,) of the determinants of Jacobians that were inverted last.
    square : (6 k, 12 k) no lanes: to invert one.
    steps : (2 k,) int64 of the Jacobian's rods.
    iterations : (1,) changes of wrenches so far, counted on and on.
    """

    residual: np.ndarray
    before: np.ndarray
    change: np.ndarray
    offset: np.ndarray
    guess: np.ndarray
    checked: np.ndarray
    inverse: np.ndarray
    jacobian: np.ndarray
    columns: np.ndarray
    moves: np.ndarray
    totals: np.ndarray
    product: np.ndarray
    signs: np.ndarray
    square: np.ndarray
    steps: np.ndarray
    iterations: np.ndarray


@njit(cache=True, nogil=True, error_model="numpy")
def solve(robot, pose, wrenches, alive, rules, exact, steps, solver, work):
    """Change the wrenches until they are right to the tolerance, and return how wrong they are:
    the sum of what is left of the conditions, and a tenth of the change that it asks for, which
    counts where a robot gives way easily.

    Parameters
    ----------
    alive : lanes that shall move.
    rules : with tolerance, iterations, and the largest change of a component in one iteration.
    exact : whether each iteration has a Jacobian of its own.
    """
    total, limit = spread(np.inf), spread(rules.tolerance)
    for row in range(PATIENCE):
        store(solver.totals, row, total)
    rest = _find_rest(robot, pose, wrenches, steps, solver, work)
    for iteration in range(rules.iterations + 1):
        if exact:
            renew_inverse(robot, pose, wrenches, alive, steps, solver, work)
        total = choose(alive, rest + WEIGHT_OF_CHANGE * _find_change(solver), total)
        past = load(solver.totals, iteration % PATIENCE)
        store(solver.totals, iteration % PATIENCE, total)
        alive = choose(is_less(total, 0.5 * past), alive, spread(0.0))
        alive = choose(is_less(total, limit), spread(0.0), alive)
        if iteration == rules.iterations or not is_any(alive):
            break
        _move(wrenches, alive, rules.largest, solver)
        solver.before[:] = solver.residual
        before, rest = rest, _find_rest(robot, pose, wrenches, steps, solver, work)
        if not exact:
            _learn(alive, solver)
            continue
        for _ in range(HALVINGS):
            worse = choose(is_less(rest, before), spread(0.0), alive)
            if not is_any(worse):
                break
            _go_back(wrenches, worse, solver)
            rest = _find_rest(robot, pose, wrenches, steps, solver, work)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def guess(robot, pose, wrenches, alive, rules, steps, solver, work):
    """Change wrenches to what the inverse Jacobian at the last solution makes of them here."""
    _find_rest(robot, pose, wrenches, steps, solver, work)
    _find_change(solver)
    _move(wrenches, alive, rules.largest, solver)


@njit(cache=True, nogil=True, error_model="numpy")
def _go_back(wrenches, lanes, solver):
    """Take back half of the last change in some lanes."""
    for row in range(len(wrenches)):
        half = choose(lanes, 0.5 * load(solver.change, row), spread(0.0))
        store(solver.change, row, load(solver.change, row) - half)
        store(wrenches, row, load(wrenches, row) - half)


@njit(cache=True, nogil=True, error_model="numpy")
def _find_rest(robot, pose, wrenches, steps, solver, work):
    """Write how far the residual is from its offset, and return the sum of magnitudes."""
    find_residual(robot, pose, wrenches, solver.residual, steps, work)
    total = spread(0.0)
    for row in range(len(solver.residual)):
        rest = load(solver.residual, row) - load(solver.offset, row)
        store(solver.residual, row, rest)
        total = total + absolute(rest)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _find_change(solver):
    """Write minus inverse times residual, and return the sum of magnitudes."""
    count, total = len(solver.residual), spread(0.0)
    for row in range(count):
        change = spread(0.0)
        for column in range(count):
            change = change - load(solver.inverse, row * count + column) * load(
                solver.residual, column
            )
        store(solver.change, row, change)
        total = total + absolute(change)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _move(wrenches, alive, largest, solver):
    """Change the wrenches of lanes that are alive; by less where they would change by much."""
    store(solver.iterations, 0, load(solver.iterations, 0) + alive)
    size, room = spread(0.0), spread(1.0)
    for row in range(len(wrenches)):
        change, now = absolute(load(solver.change, row)), absolute(load(wrenches, row))
        size = choose(is_less(size, change), change, size)
        room = choose(is_less(room, now), now, room)
    share = choose(is_less(largest * room, size), largest * room / size, spread(1.0))
    for row in range(len(wrenches)):
        change = choose(alive, load(solver.change, row) * share, spread(0.0))
        store(solver.change, row, change)
        store(wrenches, row, load(wrenches, row) + change)


@njit(cache=True, nogil=True, error_model="numpy")
def _learn(alive, solver):
    """Update the inverse by s and y, the last changes of wrenches and residual:
    B <- B + (s - B y) (s' B) / (s' B y)."""
    count = len(solver.change)
    for row in range(count):
        y = load(solver.residual, row) - load(solver.before, row)
        store(solver.before, row, y)
        store(solver.columns, row, spread(0.0))
    slope = spread(0.0)
    for row in range(count):
        by, s = spread(0.0), load(solver.change, row)
        for column in range(count):
            entry = load(solver.inverse, row * count + column)
            by = by + entry * load(solver.before, column)
            store(solver.columns, column, load(solver.columns, column) + s * entry)
        slope = slope + s * by
        store(solver.moves, row, s - by)
    known = is_less(spread(_TINY), slope * slope)
    factor = choose(known * alive, 1.0 / slope, spread(0.0))
    for row in range(count):
        gain = choose(known * alive, factor * load(solver.moves, row), spread(0.0))
        for column in range(count):
            place = row * count + column
            entry = load(solver.inverse, place) + gain * load(solver.columns, column)
            store(solver.inverse, place, entry)
