"""In which units CRISP robots are solved, and which cannot reach."""

import numpy as np
from numba import njit

from nodes.kernels.crisp_general_problem import ARC, LENGTH, RIGID, SNARE
from nodes.kernels.crisp_options import INNER, OUTER


@njit(**OUTER)
def step_reach(crisp, tolerance):
    """Return how far one step of the integrator may turn for an error near the tolerance, rad."""
    return (4e6 * tolerance / crisp.bases[0, LENGTH]) ** 0.125


@njit(**INNER)
def copy(source, target):
    """Copy a matrix."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@njit(**INNER)
def aim(newton, gap, share):
    """Aim at a share of a residual; 0 is an equilibrium."""
    for i in range(len(gap)):
        newton.target[i] = share * gap[i]


@njit(**INNER)
def balance_forces(crisp, wrench):
    """Set the tool's base force so that no force is left at its tip."""
    for i in range(3, 6):
        total = 0.0
        for load in range(len(crisp.loads)):
            total += crisp.loads[load, 1 + i]
        for rod in range(1, len(wrench)):
            total -= wrench[rod, i]
        wrench[0, i] = total


@njit(**OUTER)
def set_weights(crisp, newton):
    """Write what turns the residual into mm at the tool's tip, and the units of the wrenches."""
    weights, n = newton.weights, len(crisp.soft)
    length = crisp.bases[0, LENGTH]
    by_moment = length * length * crisp.soft[0, 0]
    for i in range(3):
        weights[i], weights[3 + i] = by_moment, by_moment * length
    for joint in range(len(crisp.joints)):
        for i in range(3):
            angle = crisp.joints[joint, RIGID] != 0 or i == 0
            weights[6 + 6 * joint + i] = 1.0
            weights[9 + 6 * joint + i] = length if angle else by_moment
    for rod in range(n):
        for i in range(3):
            newton.units[6 * rod + i] = 1 / (length * crisp.soft[rod, 0])
            newton.units[6 * rod + 3 + i] = newton.units[6 * rod + i] / length


@njit(**OUTER)
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


@njit(**INNER)
def _apart(crisp, one, two):
    total = 0.0
    for i in range(3):
        total += (crisp.bases[one, i] - crisp.bases[two, i]) ** 2
    return np.sqrt(total)
