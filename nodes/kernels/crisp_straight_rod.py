"""A straight round rod under force and moment at its ends, integrated in lanes.

The internal force n is constant, and so is m - n x r with r the way from the rod's start, and the
torsion m . t. With lengths in steps and moments in bending stiffness over a step,

    r' = t,   t' = m x t,   m = m(0) + n x r,   d' = (m + c t) x d,   c = (E I / G J - 1) m . t

where d is the body's x axis [Anderson2017] eq. (1)-(5). Without need of d it is not integrated.
"""

from numba import njit

from nodes.kernels.crisp_lanes import load, spread
from nodes.kernels.crisp_lanes_vectors import (
    add,
    add_cross,
    axis_vector,
    cross,
    dot,
    load_vector,
    scale,
    store_vector,
)
from nodes.kernels.runge_kutta import FIRST, STAGE, STAGES, WEIGHT

STAGE_ROWS = 21  # of a stage: slopes of r, t, d; its m and r; slopes of a column's way and turn
ROD_ROWS = STAGE_ROWS * STAGES  # of the workspace
_TANGENT, _MOMENT, _WAY, _COLUMN = 0, 9, 12, 15  # the slope of r is the tangent


@njit(cache=True, nogil=True, error_model="numpy")
def follow_rod(t, d, m, n, length, bending, torsion, framed, steps, work):
    """Return the way to the rod's end, and the tangent and the body's x axis there.

    Parameters
    ----------
    t, d, m, n : tangent, body's x axis, internal moment and force at the start; world axes.
    length : lanes; bending, torsion : E I and G J, in one system of units with all else.
    framed : False leaves d as it is, which is faster.
    steps : how many steps of order 8.
    work : (ROD_ROWS, LANES).
    """
    step = length * (1.0 / steps)
    rate = step * (1.0 / bending)
    m, n = scale(m, rate), scale(n, rate * step)
    twist = dot(m, t) * (bending / torsion - 1.0)
    zero = spread(0.0)
    r = zero, zero, zero
    for _ in range(steps):
        if framed:
            r, t, d = _step_frame(r, t, d, m, n, twist, work)
        else:
            r, t = _step(r, t, m, n, work)
    return scale(r, step), t, d


@njit(cache=True, nogil=True, error_model="numpy")
def _step(r, t, m, n, work):
    for stage in range(STAGES):
        row = STAGE_ROWS * stage
        ri, ti = _combine(r, t, work, stage, 0)
        store_vector(work, row, ti)
        store_vector(work, row + 3, cross(add_cross(m, n, ri), ti))
    return _combine(r, t, work, STAGES, 0)


@njit(cache=True, nogil=True, error_model="numpy")
def _step_frame(r, t, d, m, n, twist, work):
    """Step with the body's x axis, and keep what the columns need of every stage."""
    for stage in range(STAGES):
        row = STAGE_ROWS * stage
        ri, ti = _combine(r, t, work, stage, 0)
        di = _combine_one(d, work, stage, 6)
        mi = add_cross(m, n, ri)
        store_vector(work, row, ti)
        store_vector(work, row + 3, cross(mi, ti))
        store_vector(work, row + 6, cross(add(mi, scale(ti, twist)), di))
        store_vector(work, row + _MOMENT, mi)
        store_vector(work, row + _WAY, ri)
    r, t = _combine(r, t, work, STAGES, 0)
    return r, t, _combine_one(d, work, STAGES, 6)


@njit(cache=True, nogil=True, error_model="numpy")
def _combine(a, b, work, stage, offset):
    """Return two vectors at a stage; their slopes lie side by side, and are read in one go."""
    ax, ay, az = a
    bx, by, bz = b
    for term in range(FIRST[stage], FIRST[stage + 1]):
        weight, row = WEIGHT[term], STAGE_ROWS * STAGE[term] + offset
        ax = ax + weight * load(work, row)
        ay = ay + weight * load(work, row + 1)
        az = az + weight * load(work, row + 2)
        bx = bx + weight * load(work, row + 3)
        by = by + weight * load(work, row + 4)
        bz = bz + weight * load(work, row + 5)
    return (ax, ay, az), (bx, by, bz)


@njit(cache=True, nogil=True, error_model="numpy")
def _combine_one(a, work, stage, offset):
    x, y, z = a
    for term in range(FIRST[stage], FIRST[stage + 1]):
        weight, row = WEIGHT[term], STAGE_ROWS * STAGE[term] + offset
        x = x + weight * load(work, row)
        y = y + weight * load(work, row + 1)
        z = z + weight * load(work, row + 2)
    return x, y, z


@njit(cache=True, nogil=True, error_model="numpy")
def follow_rod_columns(t, d, m, n, length, bending, torsion, steps, work, columns):
    """Return the same as `follow_rod` with frame, and write how the end moves with m and n.

    A column is the change of the way r and the turn v of the frame, d(frame) = v x frame:
    r' = v x t, v' = dm + m x v + dc t, all that a change of m(0) or n brings along the rod.

    Parameters
    ----------
    columns : (36, LANES), written: for each component of m, then of n, way and turn.
    """
    step = length * (1.0 / steps)
    rate = step * (1.0 / bending)
    m, n = scale(m, rate), scale(n, rate * step)
    stiffer = bending / torsion - 1.0
    twist, t0 = dot(m, t) * stiffer, t
    zero = spread(0.0)
    r = zero, zero, zero
    for row in range(12):
        store_vector(columns, 3 * row, r)
    for _ in range(steps):
        r, t, d = _step_frame(r, t, d, m, n, twist, work)
        for column in range(6):
            dm, dn = axis_vector(column), axis_vector(column - 3)
            _step_column(columns, 6 * column, dm, dn, n, dot(dm, t0) * stiffer, work)
    for column in range(6):
        unit = rate if column < 3 else rate * step
        way, turn = load_vector(columns, 6 * column), load_vector(columns, 6 * column + 3)
        store_vector(columns, 6 * column, scale(way, unit * step))
        store_vector(columns, 6 * column + 3, scale(turn, unit))
    return scale(r, step), t, d


@njit(cache=True, nogil=True, error_model="numpy")
def _step_column(columns, first, dm, dn, n, dtwist, work):
    way, turn = load_vector(columns, first), load_vector(columns, first + 3)
    for stage in range(STAGES):
        row = STAGE_ROWS * stage
        wi, vi = _combine(way, turn, work, stage, _COLUMN)
        t, m = load_vector(work, row + _TANGENT), load_vector(work, row + _MOMENT)
        slope = add_cross(add_cross(dm, dn, load_vector(work, row + _WAY)), n, wi)
        slope = add(add_cross(slope, m, vi), scale(t, dtwist))
        store_vector(work, row + _COLUMN, cross(vi, t))
        store_vector(work, row + _COLUMN + 3, slope)
    way, turn = _combine(way, turn, work, STAGES, _COLUMN)
    store_vector(columns, first, way)
    store_vector(columns, first + 3, turn)
