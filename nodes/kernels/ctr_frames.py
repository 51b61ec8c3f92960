"""Frames of the innermost tube from the entry to the tip: one motion after the other."""

from numba import njit

from nodes.kernels.ctr_lanes import LANES
from nodes.kernels.ctr_nodes import MOTION, ROWS
from nodes.kernels.ctr_options import INNER
from nodes.kernels.ctr_pose import gather_steps, move_steps
from nodes.kernels.ctr_rotations import multiply, rotate, turn
from nodes.kernels.ctr_sincos import sincos
from nodes.kernels.ctr_tuples import put, replace


@njit(**INNER)
def place_frames(size, weights, beta, theta, base, sections, nodes, steps):
    """Write the innermost tube's frame at all nodes and return its angle at the entry and the tip.

    Parameters
    ----------
    size, weights : tuples as long as the angles and as the tubes.
    beta, theta : translation mm and rotation rad of the innermost tube.
    base : (12,) frame of the entry by rows, then its place mm.
    sections, nodes, steps : solved; `nodes.frame` and `nodes.lanes` are written.
    """
    entry, tip = theta, theta
    for i in range(len(size)):
        entry += beta * weights[i + 1] * nodes.rate[steps, i]
        tip += weights[i + 1] * (
            nodes.state[steps, i] + beta * nodes.rate[steps, i] - nodes.state[0, i]
        )
    sine, cosine = sincos(entry)
    frame, place = (0.0,) * 9, (base[9], base[10], base[11])
    for i in range(9):
        frame = replace(frame, i, base[i])
    frame = turn(frame, sine, cosine)
    put(frame, nodes.frame, steps, 0)
    put(place, nodes.frame, steps, 9)
    last = steps
    while last > 0:
        first = (last - 1) // LANES * LANES
        block = first // LANES * ROWS
        gather_steps(size, weights, first, last, sections, nodes, block)
        move_steps(size, weights, nodes.lanes, block)
        for k in range(last - 1, first - 1, -1):
            rotation, translation = _take_motion(nodes.lanes, block + MOTION, k - first)
            step = rotate(frame, translation)
            frame = multiply(frame, rotation)
            place = (place[0] + step[0], place[1] + step[1], place[2] + step[2])
            put(frame, nodes.frame, k, 0)
            put(place, nodes.frame, k, 9)
        last = first
    return entry, tip


@njit(**INNER)
def _take_motion(lanes, row, lane):
    rotation, translation = (0.0,) * 9, (0.0,) * 3
    for i in range(9):
        rotation = replace(rotation, i, lanes[row + i, lane])
    for i in range(3):
        translation = replace(translation, i, lanes[row + 9 + i, lane])
    return rotation, translation
