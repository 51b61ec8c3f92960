"""How the residual of a straight CRISP robot changes with its snares' wrenches, in lanes.

A rod that is turned as a whole with its wrench ends turned: so the six columns by moment and force
at its start are all that is needed. A start that turns by v and moves changes the end by
v x way + columns (dm - v x m, dn - v x n) and turns it by v + columns (...).
"""

from numba import njit

from nodes.kernels.crisp_lanes import load, spread, store
from nodes.kernels.crisp_lanes_vectors import (
    add,
    add_cross,
    axis_vector,
    cross,
    dot,
    load_vector,
    scale,
    store_vector,
    subtract,
)
from nodes.kernels.crisp_straight_residual import (
    SITE_ROWS,
    carried,
    entry_vector,
    meet,
    rigid_axes,
    turn_between,
    write_site,
)
from nodes.kernels.crisp_straight_rod import follow_rod_columns


@njit(cache=True, nogil=True, error_model="numpy")
def find_jacobian(robot, pose, wrenches, residual, jacobian, columns, moves, steps, work):
    """Write residual and Jacobian, and return the sum of the residual's magnitudes.

    Parameters
    ----------
    jacobian : (36 k^2, LANES), written: row by row, one a component of the residual.
    columns : (36, LANES), moves : (36 k, LANES), overwritten: of one rod by its wrench; of the tool
        at one joint by all snares' wrenches.
    """
    total, count = spread(0.0), 6 * len(robot.snare)
    t, d = load_vector(pose.frames, 0), load_vector(pose.frames, 3)
    zero = spread(0.0)
    p, start = (zero, zero, zero), zero
    for row in range(2 * count):
        store_vector(moves, 3 * row, p)
    for joint in range(len(robot.snare)):
        m, n = carried(robot, wrenches, joint)
        here, length = add_cross(m, n, p), load(pose.grasps, joint) - start
        way, t, d = follow_rod_columns(
            t, d, here, n, length, robot.bending[0], robot.torsion[0], steps[joint],
            work.rod, columns,
        )  # fmt: skip
        for column in range(count):
            _move_tool(robot, joint, column, p, here, n, way, columns, moves)
        p, start = add(p, way), load(pose.grasps, joint)
        write_site(work.tool, joint, p, t, d, add_cross(m, n, p))
        _turn_snare(robot, pose, wrenches, joint, columns, steps, work)
        total = total + meet(robot, joint, residual, work)
        for column in range(count):
            _write_column(robot, wrenches, joint, column, columns, moves, jacobian, work)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _move_tool(robot, joint, column, p, m, n, way, columns, moves):
    """Carry one column of the tool from the start of a segment to its end."""
    shift, turn = load_vector(moves, 6 * column), load_vector(moves, 6 * column + 3)
    owner, part = column // 6, column % 6
    dm, dn = axis_vector(-1), axis_vector(-1)
    if owner >= joint:
        dn = scale(axis_vector(part - 3), -1.0)
        dm = add_cross(scale(axis_vector(part), -1.0), entry_vector(robot, robot.snare[owner]), dn)
    dm = add_cross(add_cross(dm, dn, p), n, shift)
    dm, dn = add_cross(dm, m, turn), add_cross(dn, n, turn)
    shift = add_cross(shift, turn, way)
    for component in range(6):
        a = dm[component] if component < 3 else dn[component - 3]
        shift = add(shift, scale(load_vector(columns, 6 * component), a))
        turn = add(turn, scale(load_vector(columns, 6 * component + 3), a))
    store_vector(moves, 6 * column, shift)
    store_vector(moves, 6 * column + 3, turn)


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_snare(robot, pose, wrenches, joint, columns, steps, work):
    rod = robot.snare[joint]
    m, n = load_vector(wrenches, 6 * joint), load_vector(wrenches, 6 * joint + 3)
    t, d = load_vector(pose.frames, 6 * rod), load_vector(pose.frames, 6 * rod + 3)
    way, t, d = follow_rod_columns(
        t, d, m, n, load(pose.lengths, rod), robot.bending[rod], robot.torsion[rod],
        steps[len(robot.snare) + joint], work.rod, columns,
    )  # fmt: skip
    p = add(entry_vector(robot, rod), way)
    write_site(work.snares, joint, p, t, d, add_cross(m, n, way))


@njit(cache=True, nogil=True, error_model="numpy")
def _write_column(robot, wrenches, joint, column, columns, moves, jacobian, work):
    shift, turn = load_vector(moves, 6 * column), load_vector(moves, 6 * column + 3)
    zero = axis_vector(-1)
    gap, snare_turn, dm = shift, zero, zero
    if column // 6 == joint:
        part = column % 6
        way = load_vector(columns, 6 * part)
        gap, snare_turn = subtract(shift, way), load_vector(columns, 6 * part + 3)
        dm = _change_moment(robot, wrenches, joint, part, way, work)
    if robot.rigid[joint]:
        rest = _change_turn(work, SITE_ROWS * joint, turn, snare_turn)
    else:
        rest = _change_relaxed(work, SITE_ROWS * joint, turn, snare_turn, dm)
    count = 6 * len(robot.snare)
    for component in range(3):
        store(jacobian, (6 * joint + component) * count + column, gap[component])
        store(jacobian, (6 * joint + 3 + component) * count + column, rest[component])


@njit(cache=True, nogil=True, error_model="numpy")
def _change_moment(robot, wrenches, joint, part, way, work):
    """Return how the moment m + n x r at the snare's tip changes with a component of its wrench."""
    tip = load_vector(work.snares, SITE_ROWS * joint)
    r = subtract(tip, entry_vector(robot, robot.snare[joint]))
    dm = add_cross(axis_vector(part), axis_vector(part - 3), r)
    return add_cross(dm, load_vector(wrenches, 6 * joint + 3), way)


@njit(cache=True, nogil=True, error_model="numpy")
def _change_relaxed(work, row, turn, snare_turn, dm):
    t, u = load_vector(work.tool, row + 3), load_vector(work.snares, row + 3)
    m, dt, du = load_vector(work.snares, row + 9), cross(turn, t), cross(snare_turn, u)
    return dot(dt, u) + dot(t, du), dot(dm, u) + dot(m, du), dot(dm, t) + dot(m, dt)


@njit(cache=True, nogil=True, error_model="numpy")
def _change_turn(work, row, turn, snare_turn):
    tool, snare = rigid_axes(work, row)
    between, room = turn_between(tool, snare)
    skew, trace = axis_vector(-1), spread(0.0)
    for axis in range(3):
        da, db = cross(turn, tool[axis]), cross(snare_turn, snare[axis])
        skew = add_cross(add_cross(skew, da, snare[axis]), tool[axis], db)
        trace = trace + dot(da, snare[axis]) + dot(tool[axis], db)
    return scale(subtract(scale(skew, 2.0), scale(between, trace)), 1.0 / room)
