"""Configurations of one CRISP robot one after the other, each solved from those before it."""

from numba import njit

from nodes.kernels.crisp_general_batch import copy_robot, set_row
from nodes.kernels.crisp_general_sample import sample_rod
from nodes.kernels.crisp_general_solve import FINER, SOLVED, UNSTABLE, new_newton, solve_wrenches
from nodes.kernels.crisp_general_units import step_reach
from nodes.kernels.crisp_options import INNER, OUTER
from nodes.kernels.crisp_stability import EXACT, LEVEL_LIMIT, count_below, new_sturm

NEAR = 4.0  # accuracies up to which the margin is sought about the last one


@njit(**OUTER)
def follow_chain(crisp, rotations, lengths, arcs, wrenches, tolerance, accuracy, found):
    """Solve each configuration from the last, up to the first without a stable equilibrium.

    Parameters
    ----------
    crisp : Packed, whose rotations, lengths and grasp places are replaced by those of each row.
    rotations, lengths, arcs : (b, n, 3, 3), (b, n), (b, k).
    wrenches : (b, n, 6) in the first row a guess; written.
    tolerance : mm.
    accuracy : of the stability margins.
    found : (b, 4) written: status, residual in mm, evaluations with derivatives, margin.

    Returns
    -------
    How many are solved and stable.
    """
    one = copy_robot(crisp)
    newton, sturm = new_newton(crisp), new_sturm(crisp)
    margin = 0.5
    for row in range(len(wrenches)):
        set_row(one, rotations[row], lengths[row], arcs[row])
        _guess(wrenches, row, min(row, 2))
        status, size, full, _ = solve_wrenches(one, wrenches[row], tolerance, newton)
        if status != SOLVED and row > 1:
            _guess(wrenches, row, 1)
            status, size, full, _ = solve_wrenches(one, wrenches[row], tolerance, newton)
        if status == SOLVED:
            margin = _find_margin(one, wrenches[row], margin, accuracy, sturm)
            if margin <= accuracy:
                status = UNSTABLE
        found[row, 0], found[row, 1], found[row, 2], found[row, 3] = status, size, full, margin
        if status != SOLVED:
            return row
    return len(wrenches)


@njit(**INNER)
def _guess(wrenches, row, points):
    """Write a guess from one row before, or from two along a straight line; from none keep it."""
    for rod in range(wrenches.shape[1]):
        for i in range(6):
            if points > 0:
                wrenches[row, rod, i] = wrenches[row - 1, rod, i]
            if points > 1:
                wrenches[row, rod, i] += wrenches[row - 1, rod, i] - wrenches[row - 2, rod, i]


@njit(**INNER)
def _find_margin(crisp, wrench, last, accuracy, sturm):
    """Return the stability margin from one near by; 0 at most where the robot is not stable."""
    width = NEAR * accuracy
    low, high = min(last, LEVEL_LIMIT), 1.0
    while count_below(crisp, wrench, low, EXACT, sturm) > 0:
        if low <= 0.0:
            return 0.0
        high, low, width = low, max(low - width, 0.0), 4 * width
    width = NEAR * accuracy
    while high == 1.0:
        level = min(low + width, 0.5 * (1 + low))
        if level > LEVEL_LIMIT:
            return 1.0
        if count_below(crisp, wrench, level, EXACT, sturm) > 0:
            high = level
        else:
            low, width = level, 4 * width
    while high - low > accuracy:
        middle = 0.5 * (low + high)
        if count_below(crisp, wrench, middle, EXACT, sturm) > 0:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


@njit(**OUTER)
def sample_chain(crisp, rotations, lengths, arcs, wrenches, rod, places, tolerance, found):
    """Write the state of one rod in each configuration; see `sample_rod`.

    Parameters
    ----------
    places : (b, q) increasing, mm from the entry point.
    tolerance : mm, of the shape.
    found : (b, q, 18) written.
    """
    one = copy_robot(crisp)
    for row in range(len(wrenches)):
        set_row(one, rotations[row], lengths[row], arcs[row])
        reach = FINER * step_reach(one, tolerance)
        sample_rod(one, wrenches[row], rod, places[row], reach, found[row])
