"""Many configurations of one CRISP setup at once, each from a guess of its own."""

from numba import njit

from nodes.kernels.crisp_general_problem import ARC, LENGTH, Packed
from nodes.kernels.crisp_general_solve import SOLVED, UNSTABLE, new_newton, solve_wrenches
from nodes.kernels.crisp_options import OUTER
from nodes.kernels.crisp_stability import QUICK, count_below, new_sturm


@njit(**OUTER)
def copy_robot(crisp):
    """Return a robot whose bases and joints may be changed."""
    return Packed(crisp.soft, crisp.bases.copy(), crisp.joints.copy(), crisp.loads)


@njit(**OUTER)
def set_row(one, rotations, lengths, arcs):
    """Set rotations (n, 3, 3), lengths (n,) and grasp places (k,) of a robot."""
    for rod in range(len(one.bases)):
        one.bases[rod, LENGTH] = lengths[rod]
        for i in range(3):
            for axis in range(3):
                one.bases[rod, 3 + 3 * axis + i] = rotations[rod, i, axis]
    for joint in range(len(one.joints)):
        one.joints[joint, ARC] = arcs[joint]


@njit(**OUTER)
def count_unstable(crisp, rotations, lengths, arcs, wrenches, found):
    """Write how many eigenvalues below 0 the second variation of each equilibrium has.

    Parameters as of `solve_many`; found : (b,) int64, written.
    """
    one, sturm = copy_robot(crisp), new_sturm(crisp)
    for row in range(len(wrenches)):
        set_row(one, rotations[row], lengths[row], arcs[row])
        found[row] = count_below(one, wrenches[row], 0.0, QUICK, sturm)


@njit(**OUTER)
def solve_many(crisp, rotations, lengths, arcs, wrenches, tolerance, check, found):
    """Solve each configuration from its guess.

    Parameters
    ----------
    crisp : Packed, whose rotations, lengths and grasp places are replaced by those of each row.
    rotations, lengths, arcs : (b, n, 3, 3), (b, n), (b, k).
    wrenches : (b, n, 6) guesses, changed in place.
    tolerance : mm.
    check : whether equilibria that the robot would leave are told.
    found : (b, 4) written: status, residual in mm, evaluations with and without derivatives.
    """
    one = copy_robot(crisp)
    newton, sturm = new_newton(crisp), new_sturm(crisp)
    for row in range(len(wrenches)):
        set_row(one, rotations[row], lengths[row], arcs[row])
        status, size, full, short = solve_wrenches(one, wrenches[row], tolerance, newton)
        if check and status == SOLVED and count_below(one, wrenches[row], 0.0, QUICK, sturm) > 0:
            status = UNSTABLE
        found[row, 0], found[row, 1], found[row, 2], found[row, 3] = status, size, full, short
