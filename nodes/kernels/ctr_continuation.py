"""From one solved configuration to another along its branch, in steps as small as they must be."""

from numba import njit

from nodes.kernels.ctr_newton import settle
from nodes.kernels.ctr_options import INNER
from nodes.kernels.ctr_sections import cut_sections
from nodes.kernels.ctr_stability import is_stable
from nodes.kernels.ctr_tuples import add, replace, take

FIRST, SHORTEST = 0.25, 1e-4  # share of the way that one step goes
END = 2e-5  # rad, as for shapes
MOST_TURNED = 0.4  # rad, by which tips may turn against each other in one step


@njit(**INNER)
def follow(size, columns, weights, tubes, rotations, translations, x, limits, sections, nodes):
    """Follow the solution while all joint values go evenly from the first to the second row.

    A step that does not settle, or not to a stable configuration, or that turns the tips too far,
    is halved; where even the shortest fails, the robot snaps.

    Parameters
    ----------
    size, columns, weights : tuples: angles, state, shares of torsional stiffness.
    tubes : Tubes.
    rotations, translations : (3, n) start, end, and a row of scratch; rad and mm.
    x : angles of the tips to the innermost at the start.
    limits, sections, nodes : as `cut_sections` and `untwist` take them; written.

    Returns
    -------
    x at the last stable place, share of the way reached, steps of the nodes there.
    """
    share, stride, turned, steps = 0.0, FIRST, x, 0
    for i in range(len(size)):
        turned = replace(turned, i, 0.0)
    while share < 1.0 and stride >= SHORTEST:
        stride = min(stride, 1.0 - share)
        target, betas = _joints_at(size, weights, share + stride, rotations, translations)
        count = cut_sections(tubes, translations, 2, limits, sections)
        guess = add(x, stride, turned)
        y, settled, _, _, steps = settle(
            size, columns, weights, betas, target, guess, END, sections, count, nodes
        )
        far = 0.0
        for i in range(len(size)):
            far = max(far, abs(y[i] - x[i]))
        fine = settled and far < MOST_TURNED
        if fine and is_stable(size, columns, weights, betas, nodes, steps):
            for i in range(len(size)):
                turned = replace(turned, i, (y[i] - x[i]) / stride)
            share, x = share + stride, y
            stride *= 2.0
        else:
            stride *= 0.5
    if share < 1.0:  # back to the last place that was stable
        target, betas = _joints_at(size, weights, share, rotations, translations)
        count = cut_sections(tubes, translations, 2, limits, sections)
        x, _, _, _, steps = settle(
            size, columns, weights, betas, target, x, END, sections, count, nodes
        )
    return x, share, steps


@njit(**INNER)
def _joints_at(size, weights, share, rotations, translations):
    for i in range(len(weights)):
        there = rotations[0, i] + share * (rotations[1, i] - rotations[0, i])
        rotations[2, i] = there
        there = translations[0, i] + share * (translations[1, i] - translations[0, i])
        translations[2, i] = there
    target = size
    for i in range(len(size)):
        target = replace(target, i, rotations[2, i + 1] - rotations[2, 0])
    return target, take(weights, translations, 2, 0)
