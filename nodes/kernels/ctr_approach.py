"""Angles at the tips by coarse Newton steps, for eight configurations at once.

Each has its own sections, of which only those that are coupled need a step; between them angles go
on evenly. Lanes that are done stand still, so that none depends on its neighbours.
"""

from numba import njit

from nodes.kernels.ctr_lanes import LANES, choose_less, is_any_less, load_rows, spread, spread_rows
from nodes.kernels.ctr_newton import COARSE_END, COARSE_LIMIT, LONGEST, at_bases, solve_columns
from nodes.kernels.ctr_options import INNER, INSIDE
from nodes.kernels.ctr_torsion import step_order_4
from nodes.kernels.ctr_tuples import add, replace

# Rows of a group: the angles wanted, which become those at the tips, translations, then a block for
# each coupled section with the even way before it and its length (both negative), share and drive.
TARGET, BETAS, BLOCKS = 0, 4, 8


@njit(**INNER)
def pack(size, lane, target, betas, sections, count, group):
    """Write one configuration to a lane; return how many blocks it has."""
    n = len(size) + 1
    for i in range(n - 1):
        group[TARGET + i, lane] = target[i]
    for i in range(n):
        group[BETAS + i, lane] = betas[i]
    row, way = BLOCKS, 0.0
    for k in range(count):
        h = sections.place[k + 1] - sections.place[k]
        if sections.coupled[k] and h < 0.0:
            group[row, lane], group[row + 1, lane] = way, h
            for i in range(n):
                group[row + 2 + i, lane] = sections.share[k, i]
                group[row + 2 + n + i, lane] = sections.drive[k, i]
            row, way = row + 2 + 2 * n, 0.0
        else:
            way += h
    group[row, lane], group[row + 1, lane] = way, 0.0
    return (row - BLOCKS) // (2 + 2 * n) + 1


@njit(**INNER)
def clear(group):
    """Make a group of eight that have no blocks, so that ways are 0 beyond those packed later."""
    for row in range(group.shape[0]):
        for lane in range(LANES):
            group[row, lane] = 0.0


@njit(**INNER)
def approach_group(size, columns, weights, blocks, group):
    """Return angles at the tips of eight configurations, lanes."""
    target, betas = load_rows(size, group, TARGET), load_rows(weights, group, BETAS)
    x, length = target, spread(1.0)
    for _ in range(COARSE_LIMIT):
        state, rate = _untwist(size, columns, weights, x, blocks, group)
        held = at_bases(weights, betas, state, rate)
        step, length = _shorten(solve_columns(x, held, add(target, -1.0, held)), length)
        x = add(x, 1.0, step)
        if not is_any_less(spread(COARSE_END), length):
            break
    return x


@njit(**INNER)
def _untwist(size, columns, weights, x, blocks, group):
    m = len(size)
    state, rate, one = spread_rows(columns, 0.0), spread_rows(columns, 0.0), spread(1.0)
    for i in range(m):
        state = replace(state, i, x[i])
        state = replace(state, m + i * m + i, one)
    for block in range(blocks):
        row = BLOCKS + block * (2 * m + 4)
        way, h = load_rows((0.0, 0.0), group, row)
        share, drive = load_rows(weights, group, row + 2), load_rows(weights, group, row + 3 + m)
        state, rate = step_order_4(x, share, drive, h, add(state, way, rate), rate)
    return state, rate


@njit(**INSIDE)
def _shorten(step, before):
    """Return the step, shortened, 0 where the one before was short enough, and its length."""
    length = _magnitude(step[0])
    for i in range(1, len(step)):
        size = _magnitude(step[i])
        length = choose_less(length, size, size, length)
    longest = spread(LONGEST)
    share = choose_less(longest, length, longest / length, spread(1.0))
    share = choose_less(before, spread(COARSE_END), spread(0.0), share)
    for i in range(len(step)):
        step = replace(step, i, share * step[i])
    return step, choose_less(before, spread(COARSE_END), before, length)


@njit(**INSIDE)
def _magnitude(value):
    return choose_less(value, -value, -value, value)
