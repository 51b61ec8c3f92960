"""From where a straight line may lead to cells of a grid: a bound that is quick and safe.

A ray that steps from cell to cell over faces never turns back along an axis. So whatever sees a
cell stands in one of eight octants before it, at the end of a chain of free cells that goes on but
one way along each axis. The reverse is not true: such a chain may have no straight line in it.
"""

from numba import njit

from nodes.kernels.crisp_options import INNER, OUTER


@njit(**OUTER)
def mark_chains(free, goals, found):
    """Mark the free cells from which such a chain leads to any of the goals.

    Parameters
    ----------
    free, goals : (i, j, k) uint8, 1 where it is so; no goal is free.
    found : (i, j, k) uint8, zeros, written: one bit an octant.
    """
    for octant in range(8):
        _mark_octant(free, goals, found, octant)


@njit(**INNER)
def _mark_octant(free, goals, found, octant):
    bit = 1 << octant
    steps = (
        1 if octant & 1 else -1,
        1 if octant & 2 else -1,
        1 if octant & 4 else -1,
    )
    ni, nj, nk = free.shape
    for a in range(ni):
        i = a if steps[0] > 0 else ni - 1 - a
        for b in range(nj):
            j = b if steps[1] > 0 else nj - 1 - b
            for c in range(nk):
                k = c if steps[2] > 0 else nk - 1 - c
                if free[i, j, k] != 0 and (
                    (a > 0 and _leads(goals, found, bit, i - steps[0], j, k))
                    or (b > 0 and _leads(goals, found, bit, i, j - steps[1], k))
                    or (c > 0 and _leads(goals, found, bit, i, j, k - steps[2]))
                ):
                    found[i, j, k] |= bit


@njit(**INNER)
def _leads(goals, found, bit, i, j, k):
    return goals[i, j, k] != 0 or (found[i, j, k] & bit) != 0
