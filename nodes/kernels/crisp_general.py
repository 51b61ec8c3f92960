"""Residual of a whole CRISP robot and its derivatives, whatever bends it [Anderson2017] eq. (7).

Unknown are the wrenches (m, n) at the rods' bases. Rows of the residual: moment and force at the
tool's tip (3 and 3), then six for each joint in the order along the tool. Along the tool goes a
table D of twelve rows (dp, rotation vector of dR, dm, dn) with a column for each thing that may
change; the start's pose moves a piece of rod rigidly together with the wrench that acts on it, so
that the piece's own six columns serve all of them.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_general_problem import ARC, COSINE, LENGTH, RIGID, SNARE
from nodes.kernels.crisp_joints import joint_residual, joint_rows
from nodes.kernels.crisp_options import INNER
from nodes.kernels.crisp_rod import FULL, bend_full, bend_pose, count_steps


class Walk(NamedTuple):
    """Workspace and results of one evaluation.

    soft : (n, 5) 1 / EI, 1 / GJ - 1 / EI, pre-curvature of each rod.
    slopes : (14, 48) of the integrator.
    tips, acting : (n, 48), (n, 6) state and wrench at the snares' tips; row 0 where the walk stands
        on the tool.
    changes : (n, 12, c) the tables D; row 0 for the tool.
    slides : (n + k, c) how far the rods' tips, then the joints, move along their rod.
    passed : (k, 6, c) changes of the tool's pose at the joints.
    blocks : (3, 3, 3) of one joint.
    residual, rows : (6 n,), (6 n, c).
    ease : (1,) how much softer than they are rods answer in the columns, see `bend_full`.
    """

    soft: np.ndarray
    slopes: np.ndarray
    tips: np.ndarray
    acting: np.ndarray
    changes: np.ndarray
    slides: np.ndarray
    passed: np.ndarray
    blocks: np.ndarray
    residual: np.ndarray
    rows: np.ndarray
    ease: np.ndarray


@njit(**INNER)
def new_walk(crisp, columns):
    """Return a workspace for the rods of a robot and as many columns."""
    n = len(crisp.soft)
    return Walk(
        crisp.soft,
        np.zeros((14, FULL)),
        np.zeros((n, FULL)),
        np.zeros((n, 6)),
        np.zeros((n, 12, columns)),
        np.zeros((2 * n - 1, columns)),
        np.zeros((n - 1, 6, columns)),
        np.zeros((3, 3, 3)),
        np.zeros(6 * n),
        np.zeros((6 * n, columns)),
        np.ones(1),
    )


@njit(**INNER)
def place_base(crisp, rod, state):
    """Write the pose of a rod's base into the first twelve numbers of a state."""
    for i in range(12):
        state[i] = crisp.bases[rod, i]


@njit(**INNER)
def walk_robot(crisp, wrench, reach, walk, columns):
    """Fill the residual and, with columns, its derivatives.

    Parameters
    ----------
    wrench : (n, 6) moment and force at the rods' bases.
    reach : how far one step of the integrator may turn, rad.
    columns : how many columns of `walk.changes`, set before by the caller, are carried; 0 for none.
        Beyond the 6 n of `wrench` alone, the last are the loads' (moment, force).
    """
    whole = columns > 6 * len(wrench)
    acting, changes, residual, rows = walk.acting, walk.changes, walk.residual, walk.rows
    for rod in range(len(wrench) - 1, -1, -1):
        place_base(crisp, rod, walk.tips[rod])
        for i in range(6):
            acting[rod, i] = wrench[rod, i]
        if rod > 0:
            low, high = own_columns(rod, columns, whole)
            advance(crisp.bases[rod, LENGTH], rod, reach, walk, low, high)
            if whole:
                slide_along(walk, rod, rod, 1.0, columns)
    joint, load, tool, arc = np.int64(0), np.int64(0), np.int64(0), 0.0
    while True:
        then, is_joint = next_place(crisp, joint, load)
        if then == np.inf:
            break
        if then > arc:
            advance(then - arc, tool, reach, walk, tool, columns)
            arc = then
        if is_joint:
            _pass_joint(crisp, joint, walk, columns, whole)
            joint += 1
        else:
            _pass_load(crisp.loads, load, walk, columns, whole)
            load += 1
    for i in range(6):
        residual[i] = acting[0, i]
        for c in range(columns):
            rows[i, c] = changes[0, 6 + i, c]


@njit(**INNER)
def next_place(crisp, joint, load):
    """Return where something acts on the tool next, inf if nothing, and whether it is a joint."""
    joints, loads = crisp.joints, crisp.loads
    next_joint = joints[joint, ARC] if joint < len(joints) else np.inf
    next_load = loads[load, ARC] if load < len(loads) else np.inf
    return min(next_joint, next_load), next_joint <= next_load


@njit(**INNER)
def own_columns(rod, columns, whole):
    """Return the first and one past the last column that a snare depends on."""
    if whole or columns == 0:
        return np.int64(0), columns
    return 6 * rod, 6 * rod + 6


@njit(**INNER)
def advance(length, rod, reach, walk, low, high):
    """Carry a rod's state, and its columns low..high - 1, over a piece."""
    state, wrench, soft = walk.tips[rod], walk.acting[rod], walk.soft[rod]
    steps = count_steps(wrench, soft, length, reach)
    if high <= low:
        bend_pose(state, wrench, soft, length, steps, walk.slopes)
        return
    x, y, z = state[0], state[1], state[2]
    before = (wrench[0], wrench[1], wrench[2], wrench[3], wrench[4], wrench[5])
    bend_full(state, wrench, soft, walk.ease[0], length, steps, walk.slopes)
    way = (state[0] - x, state[1] - y, state[2] - z)
    carry_columns(walk.changes[rod], state, way, before, low, high)


@njit(fastmath={"contract"}, **INNER)
def carry_columns(table, state, way, wrench, low, high):
    """Carry changes of pose and wrench over a piece.

    A turned start with the wrench turned along moves the piece rigidly; what the wrench differs
    from that bends it by its own columns.

    Parameters
    ----------
    table : (12, c) rows dp, rotation vector, dm, dn, changed in place.
    state : (48,) of the end, with the derivatives by the wrench at the start.
    way, wrench : from start to end, and the wrench at the start.
    """
    x, y, z = way
    mx, my, mz, nx, ny, nz = wrench
    for c in range(low, high):
        fx, fy, fz = table[3, c], table[4, c], table[5, c]
        ax = table[6, c] - (fy * mz - fz * my)
        ay = table[7, c] - (fz * mx - fx * mz)
        az = table[8, c] - (fx * my - fy * mx)
        bx = table[9, c] - (fy * nz - fz * ny)
        by = table[10, c] - (fz * nx - fx * nz)
        bz = table[11, c] - (fx * ny - fy * nx)
        px = fy * z - fz * y
        py = fz * x - fx * z
        pz = fx * y - fy * x
        px += state[12] * ax + state[13] * ay + state[14] * az
        px += state[15] * bx + state[16] * by + state[17] * bz
        py += state[18] * ax + state[19] * ay + state[20] * az
        py += state[21] * bx + state[22] * by + state[23] * bz
        pz += state[24] * ax + state[25] * ay + state[26] * az
        pz += state[27] * bx + state[28] * by + state[29] * bz
        table[3, c] = fx + state[30] * ax + state[31] * ay + state[32] * az
        table[3, c] += state[33] * bx + state[34] * by + state[35] * bz
        table[4, c] = fy + state[36] * ax + state[37] * ay + state[38] * az
        table[4, c] += state[39] * bx + state[40] * by + state[41] * bz
        table[5, c] = fz + state[42] * ax + state[43] * ay + state[44] * az
        table[5, c] += state[45] * bx + state[46] * by + state[47] * bz
        table[0, c] += px
        table[1, c] += py
        table[2, c] += pz
        dx, dy, dz = table[9, c], table[10, c], table[11, c]
        table[6, c] -= py * nz - pz * ny + y * dz - z * dy
        table[7, c] -= pz * nx - px * nz + z * dx - x * dz
        table[8, c] -= px * ny - py * nx + x * dy - y * dx


@njit(**INNER)
def _pass_joint(crisp, joint, walk, columns, whole):
    """Write a joint's rows and hand the snare's wrench to the tool: m and n grow by m_k and n_k."""
    joints, tips, acting = crisp.joints, walk.tips, walk.acting
    rod, first, tool = int(joints[joint, SNARE]), 6 + 6 * joint, np.int64(0)
    rigid, cosine = joints[joint, RIGID] != 0, joints[joint, COSINE]
    joint_residual(tips[0], tips[rod], acting[rod], rigid, cosine, walk.residual[first:])
    if whole:
        slide_along(walk, tool, len(tips) + joint, 1.0, columns)
        copy_pose(walk.changes, walk.passed, joint, columns)
    if columns > 0:
        joint_rows(tips[0], tips[rod], acting[rod], rigid, walk.residual[first:], walk.blocks)
        low, high = own_columns(rod, columns, whole)
        _fill_rows(walk.changes, walk.blocks, walk.rows, rod, first, columns, low, high)
    for i in range(6):
        acting[0, i] += acting[rod, i]
    if whole:
        slide_along(walk, tool, len(tips) + joint, -1.0, columns)


@njit(**INNER)
def copy_pose(changes, passed, joint, columns):
    """Keep the changes of the tool's pose where a joint is."""
    for i in range(6):
        for c in range(columns):
            passed[joint, i, c] = changes[0, i, c]


@njit(**INNER)
def _fill_rows(changes, blocks, rows, rod, first, columns, low, high):
    """Write the derivatives of a joint's six numbers; add the snare's changes of wrench to the
    tool's."""
    for i in range(3):
        for c in range(columns):
            rows[first + i, c] = -changes[0, i, c]
            rows[first + 3 + i, c] = (
                blocks[0, i, 0] * changes[0, 3, c]
                + blocks[0, i, 1] * changes[0, 4, c]
                + blocks[0, i, 2] * changes[0, 5, c]
            )
        for c in range(low, high):
            rows[first + i, c] += changes[rod, i, c]
            for j in range(3):
                rows[first + 3 + i, c] += blocks[1, i, j] * changes[rod, 3 + j, c]
                rows[first + 3 + i, c] += blocks[2, i, j] * changes[rod, 6 + j, c]
    for i in range(6, 12):
        for c in range(low, high):
            changes[0, i, c] += changes[rod, i, c]


@njit(**INNER)
def _pass_load(loads, load, walk, columns, whole):
    """A load on the tool: n(s+) = n(s-) - F and m(s+) = m(s-) - T."""
    acting, changes = walk.acting, walk.changes
    for i in range(6):
        acting[0, i] -= loads[load, 1 + i]
    if whole:
        first = columns - 6 * (len(loads) - load)
        for i in range(6):
            changes[0, 6 + i, first + i] -= 1.0


@njit(**INNER)
def slide_along(walk, rod, number, sign, columns):
    """Move the place on a rod where the walk stands, in each column by its share of a mm.

    number : row of `walk.slides`.
    """
    state, wrench, soft = walk.tips[rod], walk.acting[rod], walk.soft[rod]
    table, slide = walk.changes[rod], walk.slides[number]
    along = state[9] * wrench[0] + state[10] * wrench[1] + state[11] * wrench[2]
    twist = soft[1] * along + soft[4]
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        turn = soft[0] * wrench[i] + twist * state[9 + i]
        turn += soft[2] * state[3 + i] + soft[3] * state[6 + i]
        lost = state[9 + a] * wrench[3 + b] - state[9 + b] * wrench[3 + a]
        for c in range(columns):
            table[i, c] += sign * slide[c] * state[9 + i]
            table[3 + i, c] += sign * slide[c] * turn
            table[6 + i, c] -= sign * slide[c] * lost


@njit(**INNER)
def walk_to_tip(crisp, reach, walk, columns):
    """Go on from the last thing that acts on the tool to its tip, after `walk_robot`."""
    last, tool = 0.0, np.int64(0)
    if len(crisp.joints) > 0:
        last = crisp.joints[-1, ARC]
    if len(crisp.loads) > 0:
        last = max(last, crisp.loads[-1, ARC])
    if crisp.bases[0, LENGTH] > last:
        advance(crisp.bases[0, LENGTH] - last, tool, reach, walk, tool, columns)
    slide_along(walk, tool, tool, 1.0, columns)
