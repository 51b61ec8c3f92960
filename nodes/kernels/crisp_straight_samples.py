"""Points along the needles of solved straight CRISP robots, in lanes."""

from numba import njit

from nodes.kernels.crisp_lanes import load, spread
from nodes.kernels.crisp_lanes_vectors import add, add_cross, load_vector, scale, store_vector
from nodes.kernels.crisp_straight_residual import Pose, carried, entry_vector
from nodes.kernels.crisp_straight_rod import follow_rod


@njit(cache=True, nogil=True, error_model="numpy")
def sample_groups(robot, poses, wrenches, tools, snares, work):
    """Write points, seen from the tool's entry, of groups of lanes.

    Parameters
    ----------
    poses, wrenches : as in `find_residual`, with the group first.
    tools : (group, 3 (k pieces + 2), LANES), written: entry, the ends of equal pieces of the
        segments before each joint, tip.
    snares : (group, k, 3 (pieces + 1), LANES), written: entry and the ends of equal pieces.
    work : (ROD_ROWS, LANES).
    """
    for group in range(len(poses.lengths)):
        pose = Pose(poses.frames[group], poses.lengths[group], poses.grasps[group])
        _sample_tool(robot, pose, wrenches[group], tools[group], work)
        for joint in range(len(robot.snare)):
            rod = robot.snare[joint]
            points, entry = snares[group, joint], entry_vector(robot, rod)
            t = load_vector(pose.frames, 6 * rod)
            m = load_vector(wrenches[group], 6 * joint)
            n = load_vector(wrenches[group], 6 * joint + 3)
            store_vector(points, 0, entry)
            length, bending = load(pose.lengths, rod), robot.bending[rod]
            _sample_rod(entry, t, m, n, length, bending, len(points) // 3 - 1, points, 3, work)


@njit(cache=True, nogil=True, error_model="numpy")
def _sample_tool(robot, pose, wrenches, points, work):
    joints, zero = len(robot.snare), spread(0.0)
    pieces = (len(points) // 3 - 2) // max(joints, 1)
    p, t, start = (zero, zero, zero), load_vector(pose.frames, 0), zero
    store_vector(points, 0, p)
    for joint in range(joints):
        m, n = carried(robot, wrenches, joint)
        length, row = load(pose.grasps, joint) - start, 3 + 3 * joint * pieces
        p, t = _sample_rod(
            p, t, add_cross(m, n, p), n, length, robot.bending[0], pieces, points, row, work
        )
        start = load(pose.grasps, joint)
    tip = add(p, scale(t, load(pose.lengths, 0) - start))
    store_vector(points, len(points) - 3, tip)


@njit(cache=True, nogil=True, error_model="numpy")
def _sample_rod(p, t, m, n, length, bending, pieces, points, row, work):
    """Write the ends of pieces from a row on, and return place and tangent at the last."""
    piece = length * (1.0 / pieces)
    for _ in range(pieces):
        way, t, _ = follow_rod(t, t, m, n, piece, bending, bending, False, 1, work)
        p, m = add(p, way), add_cross(m, n, way)
        store_vector(points, row, p)
        row += 3
    return p, t
