"""Points along the needles of solved straight CRISP robots, and how much they bend, in lanes."""

from numba import njit

from nodes.kernels.crisp_lanes import choose, is_less, load, spread, store
from nodes.kernels.crisp_lanes_vectors import add, add_cross, dot, load_vector, scale, store_vector
from nodes.kernels.crisp_options import INNER
from nodes.kernels.crisp_straight_residual import carried, entry_vector
from nodes.kernels.crisp_straight_rod import follow_rod


@njit(**INNER)
def sample_bends(robot, pose, wrenches, pieces, limits, points, bends, work):
    """Write points seen from the tool's entry, and how much needles bend there.

    Parameters
    ----------
    pieces : into which each snare and the tool before each joint are cut, a step of order 8 each.
    limits : (n,) squared curvature that is 1.
    points : (rows, LANES), written from the front: entry of the tool, the ends of its pieces, tip;
        then for each joint entry and ends of pieces of its snare.
    bends : (1, LANES), written: the largest squared curvature.
    work : (ROD_ROWS, LANES).
    """
    joints, zero = len(robot.snare), spread(0.0)
    p, t, start = (zero, zero, zero), load_vector(pose.frames, 0), zero
    store(bends, 0, zero)
    store_vector(points, 0, p)
    row = 3
    for joint in range(joints):
        m, n = carried(robot, wrenches, joint)
        length = load(pose.grasps, joint) - start
        p, t = _sample_rod(
            p, t, add_cross(m, n, p), n, length, robot.bending[0], limits[0], pieces, points, row,
            bends, work,
        )  # fmt: skip
        row, start = row + 3 * pieces, load(pose.grasps, joint)
    store_vector(points, row, add(p, scale(t, load(pose.lengths, 0) - start)))
    row += 3
    for joint in range(joints):
        rod = robot.snare[joint]
        entry, t = entry_vector(robot, rod), load_vector(pose.frames, 6 * rod)
        m, n = load_vector(wrenches, 6 * joint), load_vector(wrenches, 6 * joint + 3)
        store_vector(points, row, entry)
        _sample_rod(
            entry, t, m, n, load(pose.lengths, rod), robot.bending[rod], limits[rod], pieces,
            points, row + 3, bends, work,
        )  # fmt: skip
        row += 3 * pieces + 3


@njit(**INNER)
def _sample_rod(p, t, m, n, length, bending, limit, pieces, points, row, bends, work):
    """Write the ends of pieces from a row on, and return place and tangent at the last."""
    piece, most = length * (1.0 / pieces), load(bends, 0)
    weight = 1.0 / (bending * bending * limit)
    for place in range(pieces + 1):
        along = dot(m, t)
        bend = (dot(m, m) - along * along) * weight
        most = choose(is_less(most, bend), bend, most)
        if place < pieces:
            way, t, _ = follow_rod(t, t, m, n, piece, bending, bending, False, 1, work)
            p, m = add(p, way), add_cross(m, n, way)
            store_vector(points, row, p)
            row += 3
    store(bends, 0, most)
    return p, t
