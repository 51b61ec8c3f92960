"""A tree of CRISP configurations that grows on sixteen edges at once [Kuntz2017] Sec. IV-A.

Each lane draws a configuration, starts at the node nearest to it, and goes there step by step;
where a step is not free or has no solution, the one before becomes a node, and the lane draws
again. Some steps of all lanes are solved in one go, from the wrenches where they stand.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_collision import Rules as Clearances
from nodes.kernels.crisp_collision import Space
from nodes.kernels.crisp_lanes import LANES
from nodes.kernels.crisp_options import INNER, OUTER
from nodes.kernels.crisp_straight_edges import Edges, Rules, Track, follow
from nodes.kernels.crisp_straight_newton import Solver
from nodes.kernels.crisp_straight_residual import Pose, Robot, Workspace
from nodes.kernels.crisp_tree_chance import Region, draw, draw_configuration
from nodes.kernels.crisp_tree_front import (
    IDLE,
    Scale,
    aim,
    count_upright,
    lay_poses,
    lay_steps,
    orient,
)
from nodes.kernels.crisp_tree_steps import (
    check_steps,
    judge_steps,
    keep_apart,
    ready_apart,
    ready_ends,
    refuse_folds,
)
from nodes.kernels.crisp_tree_views import look_out
from nodes.kernels.nearest_poses import ROWS, insert_pose, nearest_pose

GOES_ON, IS_FULL, HAS_ENDED = 0, 1, 2
EDGES, COMPLETE, BARREN, TILTED = 8, 9, 10, 11  # places of counts after those of crisp_tree_steps


class Task(NamedTuple):
    """What does not change while a tree grows.

    entry : (3,) the tool's entry point, mm.
    limits : (n,) largest squared curvature, in the kernels' unit.
    piece : longest chord that stands for a piece of a needle, mm.
    levers : (n,) what a quaternion counts in distances, mm.
    seed : (6 k, LANES) wrenches from which every step is solved where `is_seeded` is False.
    chunk : steps that are solved in one go.
    most : nodes, the start counted.
    slides : whether edges from nodes at walls move only some joints.
    """

    robot: Robot
    rules: Rules
    clearances: Clearances
    cavity: Space
    wall: Space
    region: Region
    scale: Scale
    entry: np.ndarray
    limits: np.ndarray
    piece: float
    levers: np.ndarray
    seed: np.ndarray
    is_seeded: bool
    chunk: int
    most: int
    slides: bool


class Nodes(NamedTuple):
    """The tree, the start first; arrays have room for more.

    parents, steps : (node,) int64.
    quaternions, lengths : (node, n, 4), (node, n) mm.
    wrenches : (node, 6 k) in the kernels' units.
    tips : (node, 9) as in Track.
    failed : (node,) uint8, whether an edge from it once failed at its first step.
    size : (1,) int64 nodes that there are.
    """

    parents: np.ndarray
    steps: np.ndarray
    quaternions: np.ndarray
    lengths: np.ndarray
    wrenches: np.ndarray
    tips: np.ndarray
    failed: np.ndarray
    size: np.ndarray


class Room(NamedTuple):
    """Where kernels write as they go.

    track : of `chunk` steps and the start; held : of the start alone.
    steps : (2 k,) int64.
    points, bends : (rows, LANES), (1, LANES) as `sample_bends` writes them.
    tool_mm, snares_mm, directions : flat and (n, 3), one lane's points and tangents at the entries.
    ahead, valid, stuck : (LANES,) int64 steps ahead of where lanes stand; how many of them hold;
        whether a lane goes no further.
    quaternions, lengths, point : (n, 4), (n,), (ROWS n,) of one configuration.
    chance : (1,) uint64.
    counts : int64, what happened how often.
    """

    pose: Pose
    edges: Edges
    track: Track
    held: Track
    steps: np.ndarray
    solver: Solver
    work: Workspace
    points: np.ndarray
    bends: np.ndarray
    tool_mm: np.ndarray
    snares_mm: np.ndarray
    directions: np.ndarray
    ahead: np.ndarray
    valid: np.ndarray
    stuck: np.ndarray
    quaternions: np.ndarray
    lengths: np.ndarray
    point: np.ndarray
    chance: np.ndarray
    counts: np.ndarray


@njit(**OUTER)
def grow(task, nodes, poses, front, sights, room, rounds):
    """Go on for some rounds of `chunk` steps; return GOES_ON, IS_FULL or HAS_ENDED, and how many
    rounds there were.

    IS_FULL asks for more room for nodes and poses; HAS_ENDED says that there are as many nodes as
    asked for. However rounds are shared out to calls, the tree comes out the same.
    """
    for done in range(rounds):
        if nodes.size[0] >= task.most:
            return HAS_ENDED, done
        is_short = nodes.size[0] + LANES > len(nodes.parents)
        if is_short or poses.sizes[1] + LANES > len(poses.filled):
            return IS_FULL, done
        for lane in range(LANES):
            if front.parents[lane] == IDLE:
                _begin(task, nodes, poses, front, room, lane)
        room.ahead[:] = 0
        lay_poses(front, room.ahead, task.scale, room.pose)
        lay_steps(front, task.chunk, task.scale, room.edges)
        room.track.wrenches[0][:] = front.wrenches
        room.solver.offset[:] = 0.0
        _solve(task, front, room)
        for lane in range(LANES):
            _settle(task, nodes, poses, front, sights, room, lane)
    return GOES_ON, rounds


@njit(**INNER)
def _solve(task, front, room):
    """Find how many of the next steps are valid. The solver is called from here alone: all that
    leads to it is compiled once more in every function above."""
    robot, pose, edges, rules, steps = task.robot, room.pose, room.edges, task.rules, room.steps
    if task.is_seeded:
        follow(robot, pose, edges, room.track, rules, steps, room.solver, room.work)
    else:
        for step in range(1, len(room.track.totals)):
            if ready_apart(task, room, step):
                follow(robot, pose, edges, room.held, rules, steps, room.solver, room.work)
            keep_apart(room, step)
    judge_steps(task, room)
    check_steps(task, front, room)
    if task.is_seeded:
        if ready_ends(task, front, room):
            follow(robot, pose, edges, room.held, rules, steps, room.solver, room.work)
        refuse_folds(room)


@njit(**OUTER)
def plant(task, nodes, poses, sights, room):
    """Make the start, which is written as node 0, part of the search."""
    room.quaternions[:] = nodes.quaternions[0]
    room.lengths[:] = nodes.lengths[0]
    _scale_point(room, task.levers)
    insert_pose(poses, room.point, 0)
    nodes.size[0] = 1
    look_out(sights, task, nodes.tips[0], 0)


@njit(**INNER)
def _begin(task, nodes, poses, front, room, lane):
    """Start a new edge at the node that is nearest to a random configuration.

    Those that start while there is no node but the start go a random share of their way
    [Kuntz2017] Sec. IV-A.
    """
    parent = _choose(task, nodes, poses, room)
    front.parents[lane], front.at[lane] = parent, 0
    for needle in range(len(room.lengths)):
        front.lengths[lane, needle] = nodes.lengths[parent, needle]
        for part in range(4):
            front.quaternions[lane, needle, part] = nodes.quaternions[parent, needle, part]
    for row in range(nodes.wrenches.shape[1]):
        front.wrenches[row, lane] = nodes.wrenches[parent, row]
    count = aim(front, lane, room.quaternions, room.lengths, task.scale)
    if nodes.size[0] == 1:
        count = int(np.ceil((1.0 - draw(room.chance)) * count))
    upright = count_upright(front, lane, task.region)
    front.cut[lane] = upright < count
    front.ends[lane] = max(int(upright), 0) if front.cut[lane] else count
    room.counts[EDGES] += 1


@njit(**INNER)
def _choose(task, nodes, poses, room):
    """Draw a configuration and return the node nearest to it.

    Where an edge from that node once failed at its first step, it stands at a wall, and would fail
    again in most directions: then only some joints, drawn at random, go to what was drawn, so that
    it may slide along. Else the tree would hardly get away from walls, which hide most of what is
    drawn from the nodes behind.
    """
    draw_configuration(room.chance, task.region, room.quaternions, room.lengths)
    _scale_point(room, task.levers)
    parent, _ = nearest_pose(poses, room.point)
    if task.slides and nodes.failed[parent]:
        joints, moving = 2 * len(room.lengths), 0
        while moving == 0:
            moving = int(draw(room.chance) * 2**joints)
        for needle in range(len(room.lengths)):
            if not (moving >> (2 * needle)) & 1:
                for part in range(4):
                    room.quaternions[needle, part] = nodes.quaternions[parent, needle, part]
            if not (moving >> (2 * needle + 1)) & 1:
                room.lengths[needle] = nodes.lengths[parent, needle]
    return parent


@njit(**INNER)
def _scale_point(room, levers):
    for needle in range(len(levers)):
        for part in range(4):
            room.point[ROWS * needle + part] = levers[needle] * room.quaternions[needle, part]
        room.point[ROWS * needle + 4] = room.lengths[needle]


@njit(**INNER)
def _settle(task, nodes, poses, front, sights, room, lane):
    """Go on to the last step that holds; where a lane's edge ends, add a node.

    Where no step holds, the lane stands as it stood: that its solution is found again cannot be
    counted on.
    """
    valid = room.valid[lane]
    front.at[lane] += valid
    if valid > 0:
        for row in range(len(front.wrenches)):
            front.wrenches[row, lane] = room.track.wrenches[valid, row, lane]
        for row in range(9):
            front.tips[row, lane] = room.track.tips[valid, row, lane]
    is_there = front.at[lane] == front.ends[lane]
    if not is_there and not room.stuck[lane]:
        return
    room.counts[TILTED if front.cut[lane] else COMPLETE] += is_there
    if front.at[lane] == 0:
        room.counts[BARREN] += 1
        nodes.failed[front.parents[lane]] = 1
    elif nodes.size[0] < task.most:
        _add(task, nodes, poses, front, sights, room, lane)
    front.parents[lane] = IDLE


@njit(**INNER)
def _add(task, nodes, poses, front, sights, room, lane):
    node, step = nodes.size[0], front.at[lane]
    for needle in range(len(room.lengths)):
        q = orient(front, lane, needle, step)
        length = front.lengths[lane, needle] + step * front.growths[lane, needle]
        for part in range(4):
            room.quaternions[needle, part] = nodes.quaternions[node, needle, part] = q[part]
        room.lengths[needle] = nodes.lengths[node, needle] = length
    for row in range(nodes.wrenches.shape[1]):
        nodes.wrenches[node, row] = front.wrenches[row, lane]
    for row in range(9):
        nodes.tips[node, row] = front.tips[row, lane]
    nodes.parents[node], nodes.steps[node] = front.parents[lane], step
    nodes.size[0] = node + 1
    _scale_point(room, task.levers)
    insert_pose(poses, room.point, node)
    look_out(sights, task, nodes.tips[node], node)
