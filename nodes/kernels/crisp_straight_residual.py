"""What is left of the conditions at the joints of a straight, unloaded CRISP robot, in lanes.

Unknown are moment and force at each snare's entry. What all snares exert on the tool and the tool's
own wrench at its entry sum to zero, since nothing pulls at its tip; so the tool beyond joint k
carries minus the sum of all later snares' wrenches, and is straight beyond the last joint. The
conditions are [Kuntz2017] eq. (6) at a rigid and [Anderson2017] eq. (6), (16) at a relaxed joint.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_lanes import absolute, load, spread
from nodes.kernels.crisp_lanes_vectors import (
    add,
    add_cross,
    cross,
    dot,
    load_vector,
    scale,
    store_vector,
    subtract,
)
from nodes.kernels.crisp_straight_rod import follow_rod

SITE_ROWS = 12  # of a rod at a joint: position, tangent, body's x axis, internal moment


class Robot(NamedTuple):
    """What all lanes share, in one system of units; joints are sorted along the tool, rod 0.

    bending, torsion : (n,) E I and G J.
    entry : (n, 3).
    snare : (k,) int64, rod that grasps.
    rigid : (k,) bool.
    cosine : (k,) between the tangents at a relaxed joint.
    """

    bending: np.ndarray
    torsion: np.ndarray
    entry: np.ndarray
    snare: np.ndarray
    rigid: np.ndarray
    cosine: np.ndarray


class Pose(NamedTuple):
    """Configurations, one a lane.

    frames : (6 n, LANES) tangent and body's x axis of each rod at its entry.
    lengths : (n, LANES).
    grasps : (k, LANES) arc lengths on the tool.
    """

    frames: np.ndarray
    lengths: np.ndarray
    grasps: np.ndarray


class Workspace(NamedTuple):
    """Where kernels write as they go.

    rod : (ROD_ROWS, LANES).
    tool, snares : (SITE_ROWS k, LANES) rods at the joints.
    tip : (9, LANES) position, tangent and body's x axis of the tool's tip.
    """

    rod: np.ndarray
    tool: np.ndarray
    snares: np.ndarray
    tip: np.ndarray


@njit(cache=True, nogil=True, error_model="numpy")
def find_residual(robot, pose, wrenches, residual, steps, work):
    """Write the residual and return the sum of its magnitudes.

    Parameters
    ----------
    wrenches : (6 k, LANES) moment and force at the entry of each joint's snare.
    residual : (6 k, LANES), written: for each joint the gap, then the turn between the frames of a
        rigid joint, or for a relaxed one the cosine's error and the moments about both tangents.
    steps : (2 k,) int64 of the tool's segment before each joint, and of each joint's snare.
    """
    follow_tool(robot, pose, wrenches, np.any(robot.rigid), steps, work)
    total = spread(0.0)
    for joint in range(len(robot.snare)):
        follow_snare(robot, pose, wrenches, joint, steps, work)
        total = total + meet(robot, joint, residual, work)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def entry_vector(robot, rod):
    """Return where a rod enters, seen from the tool's entry."""
    return (
        spread(robot.entry[rod, 0] - robot.entry[0, 0]),
        spread(robot.entry[rod, 1] - robot.entry[0, 1]),
        spread(robot.entry[rod, 2] - robot.entry[0, 2]),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def carried(robot, wrenches, joint):
    """Return moment about the tool's entry and force in the tool before a joint."""
    zero = spread(0.0)
    m = n = zero, zero, zero
    for later in range(joint, len(robot.snare)):
        force = load_vector(wrenches, 6 * later + 3)
        about = cross(entry_vector(robot, robot.snare[later]), force)
        m = subtract(subtract(m, load_vector(wrenches, 6 * later)), about)
        n = subtract(n, force)
    return m, n


@njit(cache=True, nogil=True, error_model="numpy")
def follow_tool(robot, pose, wrenches, framed, steps, work):
    """Write the tool at each joint and its tip, all seen from its entry."""
    t, d = load_vector(pose.frames, 0), load_vector(pose.frames, 3)
    zero = spread(0.0)
    p, start = (zero, zero, zero), zero
    for joint in range(len(robot.snare)):
        m, n = carried(robot, wrenches, joint)
        length = load(pose.grasps, joint) - start
        way, t, d = follow_rod(
            t, d, add_cross(m, n, p), n, length, robot.bending[0], robot.torsion[0],
            framed, steps[joint], work.rod,
        )  # fmt: skip
        p, start = add(p, way), load(pose.grasps, joint)
        write_site(work.tool, joint, p, t, d, add_cross(m, n, p))
    p = add(p, scale(t, load(pose.lengths, 0) - start))
    store_vector(work.tip, 0, p)
    store_vector(work.tip, 3, t)
    store_vector(work.tip, 6, d)


@njit(cache=True, nogil=True, error_model="numpy")
def follow_snare(robot, pose, wrenches, joint, steps, work):
    """Write the tip of a joint's snare, seen from the tool's entry."""
    rod = robot.snare[joint]
    m, n = load_vector(wrenches, 6 * joint), load_vector(wrenches, 6 * joint + 3)
    t, d = load_vector(pose.frames, 6 * rod), load_vector(pose.frames, 6 * rod + 3)
    way, t, d = follow_rod(
        t, d, m, n, load(pose.lengths, rod), robot.bending[rod], robot.torsion[rod],
        robot.rigid[joint], steps[len(robot.snare) + joint], work.rod,
    )  # fmt: skip
    p = add(entry_vector(robot, rod), way)
    write_site(work.snares, joint, p, t, d, add_cross(m, n, way))


@njit(cache=True, nogil=True, error_model="numpy")
def write_site(sites, joint, p, t, d, m):
    """Write a rod at a joint: position, tangent, body's x axis, internal moment."""
    store_vector(sites, SITE_ROWS * joint, p)
    store_vector(sites, SITE_ROWS * joint + 3, t)
    store_vector(sites, SITE_ROWS * joint + 6, d)
    store_vector(sites, SITE_ROWS * joint + 9, m)


@njit(cache=True, nogil=True, error_model="numpy")
def meet(robot, joint, residual, work):
    """Write what is left of one joint's conditions and return the sum of its magnitudes."""
    row = SITE_ROWS * joint
    p, t = load_vector(work.tool, row), load_vector(work.tool, row + 3)
    q, u = load_vector(work.snares, row), load_vector(work.snares, row + 3)
    gap = subtract(p, q)
    if robot.rigid[joint]:
        tool, snare = rigid_axes(work, row)
        rest, _ = turn_between(tool, snare)
    else:
        m = load_vector(work.snares, row + 9)
        rest = dot(t, u) - robot.cosine[joint], dot(m, u), dot(m, t)
    store_vector(residual, 6 * joint, gap)
    store_vector(residual, 6 * joint + 3, rest)
    return _magnitude(gap) + _magnitude(rest)


@njit(cache=True, nogil=True, error_model="numpy")
def rigid_axes(work, row):
    """Return the tool's three axes and those of the snare that shall lie on them."""
    t, d = load_vector(work.tool, row + 3), load_vector(work.tool, row + 6)
    u, b = load_vector(work.snares, row + 3), load_vector(work.snares, row + 6)
    return (d, cross(t, d), t), (b, scale(u, -1.0), cross(u, b))


@njit(cache=True, nogil=True, error_model="numpy")
def turn_between(tool, snare):
    """Return 2 tan(angle / 2) times the axis of the turn from one triple of axes to another, and
    2 + 2 cos(angle).

    The skew part of the rotation alone, sin(angle), is zero at half a turn too.
    """
    skew, trace = cross(tool[0], snare[0]), dot(tool[0], snare[0])
    for axis in range(1, 3):
        skew = add_cross(skew, tool[axis], snare[axis])
        trace = trace + dot(tool[axis], snare[axis])
    return scale(skew, 2.0 / (1.0 + trace)), 1.0 + trace


@njit(cache=True, nogil=True, error_model="numpy")
def _magnitude(a):
    return absolute(a[0]) + absolute(a[1]) + absolute(a[2])
