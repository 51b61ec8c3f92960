"""Places, axes and wrenches along a solved rod."""

import numpy as np
from numba import njit

from nodes.kernels.crisp_general import advance, new_walk, next_place, place_base
from nodes.kernels.crisp_general_problem import LENGTH, SNARE
from nodes.kernels.crisp_options import INNER, OUTER


@njit(**OUTER)
def sample_rod(crisp, wrench, rod, arcs, reach, found):
    """Write the state at places along a rod; where something acts, that just before it.

    Parameters
    ----------
    arcs : (q,) increasing, mm from the entry point.
    found : (q, 18) written: place, axes d1, d2, d3, moment, force, world axes.
    """
    walk = new_walk(crisp, np.int64(0))
    _start(crisp, wrench, rod, walk)
    joint, load, none, arc = np.int64(0), np.int64(0), np.int64(0), 0.0
    for q in range(len(arcs)):
        while True:
            then, is_joint = next_place(crisp, joint, load)
            if rod > 0:
                then = np.inf
            goal = min(then, arcs[q])
            if goal > arc:
                advance(goal - arc, rod, reach, walk, none, none)
                arc = goal
            if then >= arcs[q]:
                break
            if is_joint:
                _take_snare(crisp, wrench, int(crisp.joints[joint, SNARE]), reach, walk)
                joint += 1
            else:
                for i in range(6):
                    walk.acting[rod, i] -= crisp.loads[load, 1 + i]
                load += 1
        for i in range(12):
            found[q, i] = walk.tips[rod, i]
        for i in range(6):
            found[q, 12 + i] = walk.acting[rod, i]


@njit(**INNER)
def _start(crisp, wrench, rod, walk):
    place_base(crisp, rod, walk.tips[rod])
    for i in range(6):
        walk.acting[rod, i] = wrench[rod, i]


@njit(**INNER)
def _take_snare(crisp, wrench, rod, reach, walk):
    """Add the wrench at a snare's tip to the tool's."""
    _start(crisp, wrench, rod, walk)
    none = np.int64(0)
    advance(crisp.bases[rod, LENGTH], rod, reach, walk, none, none)
    for i in range(6):
        walk.acting[0, i] += walk.acting[rod, i]
