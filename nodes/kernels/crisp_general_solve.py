"""Base wrenches of any CRISP robot: Newton's method on the whole residual, chords in between."""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_general import new_walk, walk_robot
from nodes.kernels.crisp_general_problem import ARC, LENGTH, RIGID, SNARE
from nodes.kernels.crisp_linear import factorise, solve_factorised

SOLVED, NO_SOLUTION, NOT_CONVERGED, UNSTABLE = 0, 1, 2, 3  # as nodes.mechanics.shapes.Status
LIMIT = 60  # evaluations of the derivatives; a solve that converges takes fewer than ten
PATIENCE = 3  # steps within which the residual has to halve
CHORD = 0.2  # a chord step has to shrink the residual to this share, or the derivatives are renewed
FINER = 0.6  # the end is checked with steps of this share of the length
HALVINGS = 5  # of a step that does not lower the residual


class Newton(NamedTuple):
    """Workspace of a solve.

    walk : of the evaluations.
    triangles, order : the factorised derivatives.
    weights : (6 n,) what turns each row into mm.
    target : (6 n,) residual that is aimed at, 0 but on the way there.
    step, trial : (n, 6).
    """

    walk: tuple
    triangles: np.ndarray
    order: np.ndarray
    weights: np.ndarray
    target: np.ndarray
    right: np.ndarray
    trial: np.ndarray


@njit(cache=True, nogil=True, error_model="numpy")
def new_newton(crisp):
    """Return a workspace for the rods of a robot."""
    n = len(crisp.soft)
    return Newton(
        new_walk(crisp, 6 * n),
        np.empty((6 * n, 6 * n)),
        np.empty(6 * n, np.int64),
        np.ones(6 * n),
        np.zeros(6 * n),
        np.empty(6 * n),
        np.empty((n, 6)),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def solve_wrenches(crisp, wrench, tolerance, newton):
    """Improve a guess of the base wrenches until the residual is below the tolerance.

    Parameters
    ----------
    crisp : Packed.
    wrench : (n, 6) moment and force at the bases, changed in place.
    tolerance : mm; angles count by the tool's length, moments by the deflection that they make.
    newton : Newton, its target zero.

    Returns
    -------
    Status, residual in mm, evaluations of the derivatives and of the residual alone.
    """
    if is_out_of_reach(crisp):
        return NO_SOLUTION, np.inf, 0, 0
    set_weights(crisp, newton.weights)
    aim(newton, newton.target, 0.0)
    return iterate(crisp, wrench, tolerance, newton)


@njit(cache=True, nogil=True, error_model="numpy")
def iterate(crisp, wrench, tolerance, newton):
    """Newton's method, halving steps, with chords while they gain."""
    columns = len(newton.weights)
    balance_forces(crisp, wrench)
    reach = step_reach(crisp, tolerance)
    size, full, short = np.inf, 0, 0
    past, age = np.inf, 0
    while full < LIMIT:
        size = measure(crisp, wrench, reach, newton, columns)
        full += 1
        if not size < np.inf:
            break
        if age % PATIENCE == 0:
            if not size < 0.5 * past:
                break
            past = size
        age += 1
        copy(newton.walk.rows, newton.triangles)
        if not factorise(newton.triangles, newton.order):
            break
        before, first = size, True
        while size >= tolerance:
            size, tries = _try_step(crisp, wrench, before, first, reach, newton)
            short += tries
            if not size < before:
                return NOT_CONVERGED, before, full, short
            if not size < CHORD * before:
                break
            before, first = size, False
        if size < tolerance:
            # The same guess with finer steps shows what the integrator's error is.
            reach *= FINER
            size = measure(crisp, wrench, reach, newton, 0)
            short += 1
            if size < tolerance:
                return SOLVED, size, full, short
            past, age = np.inf, 0
    return NOT_CONVERGED, size, full, short


@njit(cache=True, nogil=True, error_model="numpy")
def _try_step(crisp, wrench, before, halve, reach, newton):
    """Step by the factorised derivatives, shorter if asked until the residual falls.

    Returns the new residual, not below `before` if nothing was gained, and the evaluations.
    """
    walk, right, trial = newton.walk, newton.right, newton.trial
    for i in range(len(right)):
        right[i] = newton.target[i] - walk.residual[i]
    solve_factorised(newton.triangles, newton.order, right)
    share, tries = 1.0, 0
    for _ in range(HALVINGS if halve else 1):
        for rod in range(len(trial)):
            for i in range(6):
                trial[rod, i] = wrench[rod, i] + share * right[6 * rod + i]
        size = measure(crisp, trial, reach, newton, 0)
        tries += 1
        if size < (1 - 0.1 * share) * before:
            copy(trial, wrench)
            return size, tries
        share *= 0.5
    if halve:
        return np.inf, tries
    return before * (1 - 1e-12), tries


@njit(cache=True, nogil=True, error_model="numpy")
def measure(crisp, wrench, reach, newton, columns):
    """Evaluate and return the size of what is left, mm."""
    walk = newton.walk
    if columns:
        for rod in range(len(wrench)):
            for i in range(12):
                for c in range(columns):
                    own = i >= 6 and c == 6 * rod + i - 6
                    walk.changes[rod, i, c] = 1.0 if own else 0.0
    walk_robot(crisp, wrench, reach, walk, columns, False)
    total = 0.0
    for i in range(len(newton.weights)):
        total += (newton.weights[i] * (walk.residual[i] - newton.target[i])) ** 2
    return np.sqrt(total)


@njit(cache=True, nogil=True, error_model="numpy")
def step_reach(crisp, tolerance):
    """Return how far one step of the integrator may turn for an error near the tolerance, rad."""
    return (4e6 * tolerance / crisp.bases[0, LENGTH]) ** 0.125


@njit(cache=True, nogil=True, error_model="numpy")
def copy(source, target):
    """Copy a matrix."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@njit(cache=True, nogil=True, error_model="numpy")
def aim(newton, gap, share):
    """Aim at a share of a residual; 0 is an equilibrium."""
    for i in range(len(gap)):
        newton.target[i] = share * gap[i]


@njit(cache=True, nogil=True, error_model="numpy")
def balance_forces(crisp, wrench):
    """Set the tool's base force so that no force is left at its tip."""
    for i in range(3, 6):
        total = 0.0
        for load in range(len(crisp.loads)):
            total += crisp.loads[load, 1 + i]
        for rod in range(1, len(wrench)):
            total -= wrench[rod, i]
        wrench[0, i] = total


@njit(cache=True, nogil=True, error_model="numpy")
def set_weights(crisp, weights):
    """Write what turns each row of the residual into mm at the tool's tip."""
    length = crisp.bases[0, LENGTH]
    by_moment = length * length * crisp.soft[0, 0]
    for i in range(3):
        weights[i], weights[3 + i] = by_moment, by_moment * length
    for joint in range(len(crisp.joints)):
        for i in range(3):
            angle = crisp.joints[joint, RIGID] != 0 or i == 0
            weights[6 + 6 * joint + i] = 1.0
            weights[9 + 6 * joint + i] = length if angle else by_moment


@njit(cache=True, nogil=True, error_model="numpy")
def is_out_of_reach(crisp):
    """Return whether a chain of tubes is shorter than the straight way between two entry points."""
    joints = len(crisp.joints)
    for i in range(joints):
        one = int(crisp.joints[i, SNARE])
        if _apart(crisp, one, 0) > crisp.bases[one, LENGTH] + crisp.joints[i, ARC]:
            return True
        for j in range(i):
            two = int(crisp.joints[j, SNARE])
            chain = crisp.bases[one, LENGTH] + crisp.bases[two, LENGTH]
            if _apart(crisp, one, two) > chain + crisp.joints[i, ARC] - crisp.joints[j, ARC]:
                return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _apart(crisp, one, two):
    total = 0.0
    for i in range(3):
        total += (crisp.bases[one, i] - crisp.bases[two, i]) ** 2
    return np.sqrt(total)
