"""Whether the needles of a CRISP robot in one configuration touch the anatomy or one another.

Each needle is a chain of capsules about the chords between points on it, thick enough to hold the
bent rod between them. The boxes of all cells that are not free are held against them, and what lies
beyond the grid.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_collision_bends import chord_turn, rod_turn
from nodes.kernels.crisp_collision_cells import (
    border_at,
    distance_within,
    is_within_grid,
    room_at,
    to_grid,
    touches_cells,
)
from nodes.kernels.crisp_collision_needles import chains_touch
from nodes.kernels.crisp_collision_options import INNER, INSIDE, OUTER

FREE, TOUCHES_ANATOMY, NEEDLES_TOUCH, SHEATH_TOUCHES = 0, 1, 2, 3
FEWEST_PIECES = 6  # of a snare, and of the tool before each joint: they show how the curvature runs
LARGEST_TURN, LONGEST_ARC = 0.5, 1.02  # rad along a chord, and an arc of that over its chord
SHEATH_STEP = 0.05  # mm, least step of the search for the place where a needle leaves its sheath


class Space(NamedTuple):
    """Cells of a grid. Of a cavity all beyond the grid is occupied, too; of a wall it is free.

    free : (i, j, k) uint8, 1 where needles may be.
    room : (i, j, k) float32, mm, at most the distance from the cell's centre to the nearest box of
        a cell that is not free; 0 or less in those.
    spacing : (3,) mm.
    index_from_patient : (3, 4) to continuous indices; cell c covers c - 0.5 to c + 0.5.
    """

    free: np.ndarray
    room: np.ndarray
    spacing: np.ndarray
    index_from_patient: np.ndarray


class Rules(NamedTuple):
    """What counts as a touch, mm.

    radii : (n,) outer, of the tool and then of the snares in the order of their points.
    margin : least distance between surfaces and anatomy.
    sheath : how much of a needle from its entry point on may lie in the introducer sheath.
    grasp : how much of a snare before its tip may touch the tool.
    outside : how far the sheath goes straight back from the entry point.
    clear : where a needle is this far from all anatomy, or `margin` if that is more, it has left
        its sheath.
    """

    radii: np.ndarray
    margin: float
    sheath: float
    grasp: float
    outside: float
    clear: float = 0.0


@njit(**OUTER)
def step_is_free(tool, snares, directions, rules, cavity, wall):
    """Return FREE, TOUCHES_ANATOMY, NEEDLES_TOUCH or SHEATH_TOUCHES.

    Parameters
    ----------
    tool : (k pieces + 2, 3) float64, patient mm: entry point, the ends of equal pieces of what lies
        before each joint, tip; at least FEWEST_PIECES.
    snares : (k, pieces + 1, 3) float64, in the order of their joints along the tool.
    directions : (k + 1, 3) unit tangents at the entry points, the tool first.
    rules : Rules; radii in that order, too.
    cavity : Space of the cells in which needles may be.
    wall : Space without what the sheaths avoid outside; none is looked at if it has no cells.
    """
    pieces = snares.shape[1] - 1
    if not _needle_is_free(tool, pieces, rules.radii[0], rules, cavity):
        return TOUCHES_ANATOMY
    for snare in range(len(snares)):
        if not _needle_is_free(snares[snare], pieces, rules.radii[snare + 1], rules, cavity):
            return TOUCHES_ANATOMY
    if _needles_touch(tool, snares, rules):
        return NEEDLES_TOUCH
    if wall.free.size > 0 and _sheaths_touch(tool, snares, directions, rules, wall):
        return SHEATH_TOUCHES
    return FREE


@njit(**INNER)
def _needle_is_free(points, pieces, radius, rules, cavity):
    """Return whether a needle touches nothing after it left its sheath.

    Where the distance to the nearest box exceeds the way along the needle, it is free without
    further looks; other chords are held against boxes.
    """
    radius += rules.margin
    beyond = max(rules.clear - rules.margin, 0.0)
    clear, sheath, is_out = 0.0, rules.sheath, False
    start = to_grid(cavity, points[0, 0], points[0, 1], points[0, 2])
    for chord in range(len(points) - 1):
        end = to_grid(cavity, points[chord + 1, 0], points[chord + 1, 1], points[chord + 1, 2])
        length = _distance(start, end)
        if is_out and clear < LONGEST_ARC * length:
            clear = min(room_at(cavity, start[0], start[1], start[2]), border_at(cavity, start))
            clear -= radius
        if not clear >= LONGEST_ARC * length:
            turn = _turn_along(points, chord, pieces)
            if turn > LARGEST_TURN:
                return False
            thick = radius + turn * length / 8.0
            if not is_out:
                share = _leave_sheath(cavity, start, end, length, thick + beyond)
                sheath -= share * length
                if not sheath >= 0.0:  # nan is not free
                    return False
                is_out = share < 1.0
                start = _between(start, end, share)
            if is_out and _capsule_touches(cavity, start, end, thick):
                return False
        clear -= LONGEST_ARC * length
        start = end
    return True


@njit(**INSIDE)
def _capsule_touches(cavity, start, end, radius):
    if not is_within_grid(cavity, start, end, radius):
        return True
    return touches_cells(cavity, start, end, radius)


@njit(**INSIDE)
def _turn_along(points, chord, pieces):
    """Return a bound of a needle's turn along a chord, rad; beyond all joints it is straight."""
    first = chord - chord % pieces
    if first + pieces >= len(points):
        return 0.0
    return chord_turn(points, chord, first, pieces)


@njit(**INSIDE)
def _leave_sheath(cavity, start, end, length, radius):
    """Return the share of a chord up to the first ball on it that touches nothing; 1 if none.

    As the distance changes by no more than the way, none is passed over but by SHEATH_STEP.
    """
    way = 0.0
    while way < length:
        point = _between(start, end, way / length)
        missing = radius - max(min(border_at(cavity, point), radius), 0.0)
        if missing < radius:
            missing = max(missing, radius - distance_within(cavity, point, radius))
        if missing <= 0.0:
            return way / length
        way += max(missing, SHEATH_STEP)
    return 1.0


@njit(**INNER)
def _needles_touch(tool, snares, rules):
    pieces = snares.shape[1] - 1
    bent = _sagitta(tool, pieces)
    for snare in range(len(snares)):
        radius = rules.radii[snare + 1] + _sagitta(snares[snare], pieces)
        if chains_touch(snares[snare], rules.grasp, tool, radius + rules.radii[0] + bent):
            return True
        for other in range(snare):
            reach = radius + rules.radii[other + 1] + _sagitta(snares[other], pieces)
            if chains_touch(snares[snare], 0.0, snares[other], reach):
                return True
    return False


@njit(**INSIDE)
def _sagitta(points, pieces):
    """Return a bound of the distance between a needle and its chords."""
    most = 0.0
    for first in range(0, len(points) - pieces, pieces):
        x = points[first + 1, 0] - points[first, 0]
        y = points[first + 1, 1] - points[first, 1]
        z = points[first + 1, 2] - points[first, 2]
        length = LONGEST_ARC * sqrt(x * x + y * y + z * z)
        most = max(most, rod_turn(points, first, pieces) * length / 8.0)
    return most


@njit(**INNER)
def _sheaths_touch(tool, snares, directions, rules, wall):
    for needle in range(len(directions)):
        entry = tool[0] if needle == 0 else snares[needle - 1, 0]
        way, back = directions[needle], rules.outside
        x, y, z = entry[0], entry[1], entry[2]
        start = to_grid(wall, x, y, z)
        end = to_grid(wall, x - back * way[0], y - back * way[1], z - back * way[2])
        if touches_cells(wall, start, end, rules.radii[needle] + rules.margin):
            return True
    return False


@njit(**INSIDE)
def _between(start, end, share):
    return (
        start[0] + share * (end[0] - start[0]),
        start[1] + share * (end[1] - start[1]),
        start[2] + share * (end[2] - start[2]),
    )


@njit(**INSIDE)
def _distance(start, end):
    x, y, z = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    return sqrt(x * x + y * y + z * z)


@njit(**OUTER)
def check_robots(tools, snares, directions, rules, cavity, wall, codes):
    """Write what `step_is_free` returns for each robot, the first axis of all that is handed in."""
    for robot in range(len(codes)):
        codes[robot] = step_is_free(
            tools[robot], snares[robot], directions[robot], rules, cavity, wall
        )
