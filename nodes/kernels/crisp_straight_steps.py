"""How many steps each rod of a straight CRISP robot needs, measured by taking more."""

from numba import njit

from nodes.kernels.crisp_lanes import absolute, choose, is_any, is_less, load, spread
from nodes.kernels.crisp_lanes_vectors import add_cross, load_vector, subtract
from nodes.kernels.crisp_straight_residual import SITE_ROWS, carried, follow_tool
from nodes.kernels.crisp_straight_rod import follow_rod

LADDER = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)
_USUAL = 3  # rung whose steps find where the tool's later segments start


@njit(cache=True, nogil=True, error_model="numpy")
def choose_steps(robot, pose, wrenches, alive, budget, steps, work):
    """Write the least numbers of steps whose error is below the budget, and return lanes, 0 where
    none is enough.

    Parameters
    ----------
    alive : lanes that count, not 0.
    budget : error at the end of one rod: of its place, and of its axes times the unit of length.
    steps : (2 k,) int64, written: the tool before each joint, each joint's snare.
    """
    joints, fine = len(robot.snare), spread(1.0)
    steps[:] = LADDER[_USUAL]
    follow_tool(robot, pose, wrenches, True, steps, work)
    for joint in range(joints):
        t, d, length = load_vector(pose.frames, 0), load_vector(pose.frames, 3), spread(0.0)
        m, n = carried(robot, wrenches, joint)
        if joint > 0:
            row, length = SITE_ROWS * (joint - 1), load(pose.grasps, joint - 1)
            t, d = load_vector(work.tool, row + 3), load_vector(work.tool, row + 6)
            m = add_cross(m, n, load_vector(work.tool, row))
        length = load(pose.grasps, joint) - length
        steps[joint], enough = _count_steps(
            t, d, m, n, length, robot.bending[0], robot.torsion[0], True, alive, budget, work.rod
        )
        fine = fine * enough
        rod = robot.snare[joint]
        t, d = load_vector(pose.frames, 6 * rod), load_vector(pose.frames, 6 * rod + 3)
        m, n = load_vector(wrenches, 6 * joint), load_vector(wrenches, 6 * joint + 3)
        steps[joints + joint], enough = _count_steps(
            t, d, m, n, load(pose.lengths, rod), robot.bending[rod], robot.torsion[rod],
            robot.rigid[joint], alive, budget, work.rod,
        )  # fmt: skip
        fine = fine * enough
    return fine


@njit(cache=True, nogil=True, error_model="numpy")
def _count_steps(t, d, m, n, length, bending, torsion, framed, alive, budget, work):
    """Return the first of the ladder's numbers that the next one agrees with, and in which lanes.

    The last one if none is.
    """
    allowed, enough, rung = spread(budget), spread(0.0), 0
    end = follow_rod(t, d, m, n, length, bending, torsion, framed, LADDER[0], work)
    while rung < len(LADDER) - 1:
        finer = follow_rod(t, d, m, n, length, bending, torsion, framed, LADDER[rung + 1], work)
        error = _size(subtract(finer[0], end[0])) + _size(subtract(finer[1], end[1]))
        enough = is_less(error + _size(subtract(finer[2], end[2])), allowed)
        if not is_any(choose(alive, 1.0 - enough, spread(0.0))):
            break
        end, rung = finer, rung + 1
    return LADDER[rung], enough


@njit(cache=True, nogil=True, error_model="numpy")
def _size(a):
    return absolute(a[0]) + absolute(a[1]) + absolute(a[2])
