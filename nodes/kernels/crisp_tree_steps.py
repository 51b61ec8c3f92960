"""The next steps of edges on which a tree grows: solved, and tested for touching."""

import numpy as np
from numba import njit

from nodes.kernels.crisp_collision import FEWEST_PIECES, step_is_free
from nodes.kernels.crisp_lanes import LANES
from nodes.kernels.crisp_options import INNER
from nodes.kernels.crisp_straight_edges import move_pose
from nodes.kernels.crisp_tree_front import lay_poses
from nodes.kernels.crisp_tree_samples import sample_bends

UNSOLVED = 0  # places of counts; 1, 2, 3 are what collision tells
OVERBENT, FOLDS, SOLVED, TESTED = 4, 5, 6, 7


@njit(**INNER)
def ready_apart(task, room, step):
    """Move all lanes to a step and return whether any goes so far; each is solved from one seed,
    whatever the step before was."""
    move_pose(room.pose, room.edges)
    room.held.wrenches[0][:] = task.seed
    is_any = False
    for lane in range(LANES):
        room.ahead[lane] = int(room.edges.counts[0, lane])
        room.edges.counts[0, lane] = 0.0 if step <= room.ahead[lane] else -1.0
        is_any = is_any or step <= room.ahead[lane]
    return is_any


@njit(**INNER)
def keep_apart(room, step):
    """Write what was found at a step into the track."""
    room.track.wrenches[step][:] = room.held.wrenches[0]
    room.track.tips[step][:] = room.held.tips[0]
    room.track.totals[step][:] = room.held.totals[0]
    for lane in range(LANES):
        room.edges.counts[0, lane] = room.ahead[lane]


@njit(**INNER)
def judge_steps(task, room):
    """Write how many of the next steps have a solution on the branch that is followed."""
    limit = task.rules.tolerance
    for lane in range(LANES):
        count, held = int(room.edges.counts[0, lane]), 0
        if room.track.totals[0, 0, lane] < limit or not task.is_seeded:
            while held < count and room.track.totals[held + 1, 0, lane] < limit:
                held += 1
        if task.is_seeded and held == 1 and count > 1:
            held = 0  # the second step shows whether the first one jumped
        room.counts[SOLVED] += held
        room.valid[lane] = held
        room.stuck[lane] = held < count
        room.counts[UNSOLVED] += held < count


@njit(**INNER)
def check_steps(task, front, room):
    """Keep of the steps that are solved those before the first at which a needle touches anything
    or bends too much."""
    room.ahead[:] = 0
    lay_poses(front, room.ahead, task.scale, room.pose)
    most = room.valid.max()
    for step in range(1, most + 1):
        move_pose(room.pose, room.edges)
        pieces = _count_pieces(task, room, step)
        sample_bends(
            task.robot, room.pose, room.track.wrenches[step], pieces, task.limits, room.points,
            room.bends, room.work.rod,
        )  # fmt: skip
        for lane in range(LANES):
            if step <= room.valid[lane]:
                room.counts[TESTED] += 1
                touched = OVERBENT
                if room.bends[0, lane] <= 1.0:
                    touched = _touches(task, room, lane, pieces)
                if touched > 0:
                    room.counts[touched] += 1
                    room.valid[lane], room.stuck[lane] = step - 1, 1


@njit(**INNER)
def _count_pieces(task, room, step):
    """Return into how many pieces the longest needle of this step is cut."""
    longest = 0.0
    for lane in range(LANES):
        if step <= room.valid[lane]:
            for needle in range(len(room.pose.lengths)):
                longest = max(longest, room.pose.lengths[needle, lane])
    return max(FEWEST_PIECES, int(np.ceil(longest * task.scale.unit / task.piece)))


@njit(**INNER)
def _touches(task, room, lane, pieces):
    """Return what one lane's needles touch, as `step_is_free` tells it."""
    joints = len(task.robot.snare)
    tool, snare = joints * pieces + 2, pieces + 1
    tool_mm = room.tool_mm[: 3 * tool].reshape(tool, 3)
    snares_mm = room.snares_mm[: 3 * joints * snare].reshape(joints, snare, 3)
    unit, entry = task.scale.unit, task.entry
    for axis in range(3):
        for point in range(tool):
            tool_mm[point, axis] = unit * room.points[3 * point + axis, lane] + entry[axis]
        room.directions[0, axis] = room.pose.frames[axis, lane]
        for joint in range(joints):
            first = 3 * (tool + joint * snare) + axis
            for point in range(snare):
                place = room.points[first + 3 * point, lane]
                snares_mm[joint, point, axis] = unit * place + entry[axis]
            row = 6 * task.robot.snare[joint] + axis
            room.directions[joint + 1, axis] = room.pose.frames[row, lane]
    return step_is_free(
        tool_mm, snares_mm, room.directions, task.clearances, task.cavity, task.wall
    )


@njit(**INNER)
def ready_ends(task, front, room):
    """Move lanes that stop early to their last valid steps, and return whether there are any."""
    is_any = False
    for lane in range(LANES):
        reached_all = room.valid[lane] == room.edges.counts[0, lane]
        is_wanted = room.valid[lane] > 0 and not reached_all
        is_any = is_any or is_wanted
        room.ahead[lane] = room.valid[lane] if is_wanted else 0
        for row in range(len(front.wrenches)):
            room.held.wrenches[0, row, lane] = room.track.wrenches[room.ahead[lane], row, lane]
    if is_any:
        lay_poses(front, room.ahead, task.scale, room.pose)
        for lane in range(LANES):
            room.edges.counts[0, lane] = 0.0 if room.ahead[lane] > 0 else -1.0
    return is_any


@njit(**INNER)
def refuse_folds(room):
    """Keep no step where the Jacobian's determinant has changed its sign at the last one.

    Its sign there is known where lanes went all of their steps; else it was found at the ends.
    """
    for lane in range(LANES):
        if room.valid[lane] > 0:
            signs = room.held.signs[0] if room.ahead[lane] > 0 else room.track.signs[1]
            if signs[0, lane] != room.track.signs[0, 0, lane]:
                room.valid[lane], room.stuck[lane] = 0, 1
                room.counts[FOLDS] += 1
