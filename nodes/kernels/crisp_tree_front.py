"""Edges on which a tree of CRISP configurations is growing, one a lane, and their poses."""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_lanes import LANES
from nodes.kernels.crisp_options import INNER
from nodes.kernels.crisp_tree_chance import multiply, to_matrix, turn_between, turn_quaternion

IDLE = -1


class Front(NamedTuple):
    """Edges, from a node of the tree towards a random configuration; the lane comes first.

    parents : (LANES,) int64 node from which each starts, or IDLE.
    at, ends : (LANES,) int64 steps behind it, and after which it ends.
    cut : (LANES,) int64, whether it ends there since a needle would tilt too far.
    quaternions, lengths : (LANES, n, 4), (LANES, n) at the parent; mm.
    turns, growths : (LANES, n, 3), (LANES, n) rotation vector and growth in one step.
    wrenches, tips : (6 k, LANES), (9, LANES) where it stands, after its first steps.
    """

    parents: np.ndarray
    at: np.ndarray
    ends: np.ndarray
    cut: np.ndarray
    quaternions: np.ndarray
    lengths: np.ndarray
    turns: np.ndarray
    growths: np.ndarray
    wrenches: np.ndarray
    tips: np.ndarray


class Scale(NamedTuple):
    """How configurations become poses in the kernels' unit.

    unit : mm that are 1.
    slides, offsets : (k,) a joint's place on the tool is its length times slide, plus offset, mm.
    step_rad, step_mm : largest step of a needle's orientation and length.
    """

    unit: float
    slides: np.ndarray
    offsets: np.ndarray
    step_rad: float
    step_mm: float


@njit(**INNER)
def aim(front, lane, quaternions, lengths, scale):
    """Lay a lane's edge from where it starts to a configuration, and return its number of steps."""
    most = 1.0
    for needle in range(len(lengths)):
        turn = turn_between(front.quaternions[lane, needle], quaternions[needle])
        growth = lengths[needle] - front.lengths[lane, needle]
        angle = np.sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2])
        most = max(most, angle / scale.step_rad, abs(growth) / scale.step_mm)
        for axis in range(3):
            front.turns[lane, needle, axis] = turn[axis]
        front.growths[lane, needle] = growth
    count = int(np.ceil(most))
    for needle in range(len(lengths)):
        for axis in range(3):
            front.turns[lane, needle, axis] /= count
        front.growths[lane, needle] /= count
    return count


@njit(**INNER)
def count_upright(front, lane, region):
    """Return after how many steps of its edge a lane's first needle leaves its cone.

    A tangent t that turns about u is at a cosine A + B cos x + C sin x from an axis a, with
    A = (u t) (u a), B = t a - A and C = (u x t) a; so it is within the cone on one arc.
    """
    fewest = np.inf
    for needle in range(front.lengths.shape[1]):
        u, v, w = front.turns[lane, needle]
        angle = np.sqrt(u * u + v * v + w * w)
        if angle == 0.0:
            continue
        u, v, w = u / angle, v / angle, w / angle
        matrix = to_matrix(front.quaternions[lane, needle])
        x, y, z = matrix[2], matrix[5], matrix[8]
        a, b, c = region.directions[needle]
        still = (u * x + v * y + w * z) * (u * a + v * b + w * c)
        even = a * x + b * y + c * z - still
        odd = (v * z - w * y) * a + (w * x - u * z) * b + (u * y - v * x) * c
        size, height = np.sqrt(even * even + odd * odd), region.heights[needle] - still
        if height > -size:
            arc = np.arccos(height / size) if height < size else 0.0
            fewest = min(fewest, (np.arctan2(odd, even) + arc) / angle)
    return fewest


@njit(**INNER)
def orient(front, lane, needle, step):
    """Return a needle's unit quaternion at a step of a lane's edge."""
    turn = turn_quaternion(front.turns[lane, needle], float(step))
    w, x, y, z = multiply(turn, front.quaternions[lane, needle])
    factor = 1.0 / np.sqrt(w * w + x * x + y * y + z * z)
    return factor * w, factor * x, factor * y, factor * z


@njit(**INNER)
def lay_poses(front, ahead, scale, pose):
    """Write the poses of all lanes, so many steps (LANES,) beyond where they stand."""
    needles = front.lengths.shape[1]
    for lane in range(LANES):
        step = front.at[lane] + ahead[lane]
        for needle in range(needles):
            matrix = to_matrix(orient(front, lane, needle, step))
            for axis in range(3):
                pose.frames[6 * needle + axis, lane] = matrix[3 * axis + 2]
                pose.frames[6 * needle + 3 + axis, lane] = matrix[3 * axis]
            length = front.lengths[lane, needle] + step * front.growths[lane, needle]
            pose.lengths[needle, lane] = length / scale.unit
        tool = pose.lengths[0, lane]
        for joint in range(len(scale.slides)):
            offset = scale.offsets[joint] / scale.unit
            pose.grasps[joint, lane] = scale.slides[joint] * tool + offset


@njit(**INNER)
def lay_steps(front, chunk, scale, edges):
    """Write what changes in one step of each lane, and how many steps are next."""
    needles = front.lengths.shape[1]
    for lane in range(LANES):
        for needle in range(needles):
            matrix = to_matrix(turn_quaternion(front.turns[lane, needle], 1.0))
            for entry in range(9):
                edges.turns[9 * needle + entry, lane] = matrix[entry]
            edges.advances[needle, lane] = front.growths[lane, needle] / scale.unit
        for joint in range(len(scale.slides)):
            edges.slides[joint, lane] = scale.slides[joint] * edges.advances[0, lane]
        edges.counts[0, lane] = min(chunk, front.ends[lane] - front.at[lane])
