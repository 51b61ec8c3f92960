"""How far an equilibrium is from snapping: the least eigenvalue of its second variation.

The energy's second variation in the body curvatures, measured against their own elastic energy and
restricted to what the joints allow, has an eigenvalue below `level` for each way to be unstable of
a robot that is softer by 1 / (1 - level) but has the same shape and wrenches. These ways are
counted exactly [Wittrick1971]: rods are cut into pieces too short to buckle between held ends, the
pieces' stiffness at the cuts is eliminated from the bases on, and each negative pivot is one.

With rotation vectors phi about the solution the second variation is the integral of
phi'. R K R^T phi' - m . (phi x phi') - n . (phi x (phi x d3)), and at a relaxed joint the curvature
of the condition on the angle times its multiplier. A moment load keeps its world axis.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_general import new_walk, next_place
from nodes.kernels.crisp_general_problem import LENGTH, RIGID, SNARE
from nodes.kernels.crisp_options import INNER, OUTER
from nodes.kernels.crisp_rod import FULL, MOST_STEPS, bend_full
from nodes.kernels.crisp_stiffness import (
    eliminate,
    free_turns,
    invert_derivative,
    make_symmetric,
    piece_stiffness,
    turn_stiffness,
)

SAFE = 0.9  # share of the length at which a held piece could buckle
QUICK, EXACT = 1.0, 0.4  # rad, that a step of the integrator may turn
SLACK = 1e-12  # of its bending is how a piece stretches, else a straight one had no inverse
SHORT = 0.05  # of its rod is a piece that stretches as if it were longer, or rounding drowned it
NO_LENGTH = 4e-5  # of the tool, between places that count as one: the piece would be rounding
MOST_PIECES = 2000  # of one rod
LEVEL_LIMIT = 1 - 1e-4  # above this a robot has next to no wrench in it
LARGEST = 1e6  # negative eigenvalue that is looked for


class Sturm(NamedTuple):
    """Workspace.

    soft, slopes, state : as in Walk; the state of one piece.
    frames, acting, stiff : (n, 3, 3), (n, 6), (n, 6, 6) where each rod ends that has been bent so
        far: its axes in the world, and in these axes wrench and stiffness.
    large : (12, 12) what is being eliminated.
    """

    soft: np.ndarray
    slopes: np.ndarray
    state: np.ndarray
    frames: np.ndarray
    acting: np.ndarray
    stiff: np.ndarray
    large: np.ndarray
    square: np.ndarray
    inverse: np.ndarray
    turn: np.ndarray
    column: np.ndarray
    order: np.ndarray


@njit(**OUTER)
def new_sturm(crisp):
    """Return a workspace for the rods of a robot."""
    n, walk = len(crisp.soft), new_walk(crisp, np.int64(0))
    return Sturm(
        walk.soft,
        walk.slopes,
        np.zeros(FULL),
        np.zeros((n, 3, 3)),
        walk.acting,
        np.zeros((n, 6, 6)),
        np.zeros((12, 12)),
        np.zeros((6, 6)),
        np.zeros((6, 6)),
        np.zeros((3, 3)),
        np.zeros(6),
        np.zeros(6, np.int64),
    )


@njit(**OUTER)
def stability_margin(crisp, wrench, accuracy, sturm):
    """Return the least eigenvalue to `accuracy`: 1 for a free rod, negative where it snaps."""
    low, high = 0.0, 0.0
    if count_below(crisp, wrench, 0.0, EXACT, sturm) > 0:
        low = -1.0
        while count_below(crisp, wrench, low, EXACT, sturm) > 0:
            high, low = low, 2 * low
            if low < -LARGEST:
                return -np.inf
    else:
        while count_below(crisp, wrench, high, EXACT, sturm) == 0:
            low, high = high, 0.5 * (1 + high)
            if high > LEVEL_LIMIT:
                return 1.0
    while high - low > accuracy:
        middle = 0.5 * (low + high)
        if count_below(crisp, wrench, middle, EXACT, sturm) > 0:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


@njit(**OUTER)
def count_below(crisp, wrench, level, turn, sturm):
    """Return how many eigenvalues of an equilibrium's second variation are below `level` < 1.

    turn : what a step of the integrator turns at most, rad: QUICK to count, EXACT to measure.
    """
    ease, found = 1 / (1 - level), 0
    for rod in range(len(wrench) - 1, -1, -1):
        for i in range(3):
            for j in range(3):
                sturm.frames[rod, i, j] = crisp.bases[rod, 3 + 3 * j + i]
            sturm.acting[rod, i], sturm.acting[rod, 3 + i] = 0.0, 0.0
        _add_wrench(sturm.acting[rod], sturm.frames[rod], wrench[rod, :3], wrench[rod, 3:], 1.0)
        if rod > 0:
            whole = crisp.bases[rod, LENGTH]
            found += _add_pieces(rod, whole, whole, ease, turn, rod > 0, sturm)
    joint, load, tool, arc = np.int64(0), np.int64(0), np.int64(0), 0.0
    whole = crisp.bases[tool, LENGTH]
    while True:
        then, is_joint = next_place(crisp, joint, load)
        if then == np.inf:
            break
        if then - arc > NO_LENGTH * whole:
            found += _add_pieces(tool, then - arc, whole, ease, turn, arc == 0.0, sturm)
            arc = then
        if is_joint:
            rod = int(crisp.joints[joint, SNARE])
            found += _add_joint(rod, crisp.joints[joint, RIGID] != 0, sturm)
            joint += 1
        else:
            moment, force = crisp.loads[load, 1:4], crisp.loads[load, 4:]
            _add_wrench(sturm.acting[0], sturm.frames[0], moment, force, -1.0)
            load += 1
    if arc > 0.0:
        for i in range(6):
            for j in range(6):
                sturm.large[i, j] = sturm.stiff[0, i, j]
        found += eliminate(sturm.large, 6, 6)
    return found


@njit(**INNER)
def _add_wrench(acting, frame, moment, force, sign):
    """Add a wrench in world axes to one in the body's."""
    for i in range(3):
        for j in range(3):
            acting[i] += sign * frame[j, i] * moment[j]
            acting[3 + i] += sign * frame[j, i] * force[j]


@njit(**INNER)
def _add_pieces(rod, length, whole, ease, turn, first, sturm):
    """Lengthen a rod by a stretch; its stiffness at the end replaces that at the start.

    Each piece is seen in the body's axes at its start, so that a straight piece, which does not
    stretch, keeps that apart from how it bends.

    whole : length of the rod, mm.
    first : True where the stretch begins at the base, which is held.
    """
    soft, state, wrench, large = sturm.soft[rod], sturm.state, sturm.acting[rod], sturm.large
    pieces, steps = _cut(wrench, soft, length, ease, turn)
    found, side = 0, length / pieces
    slack = SLACK * ease * soft[0] * max(side, SHORT * whole) ** 3
    for piece in range(pieces):
        for i in range(12):
            state[i] = 1.0 if i == 3 or i == 7 or i == 11 else 0.0
        moment, force = (wrench[0], wrench[1], wrench[2]), (wrench[3], wrench[4], wrench[5])
        bend_full(state, wrench, soft, ease, side, steps, sturm.slopes)
        invert_derivative(state, slack, sturm.square, sturm.order, sturm.column, sturm.inverse)
        way = (state[0], state[1], state[2])
        piece_stiffness(way, moment, force, sturm.inverse, large)
        make_symmetric(large)
        if piece > 0 or not first:
            for i in range(6):
                for j in range(6):
                    large[i, j] += sturm.stiff[rod, i, j]
            found += eliminate(large, 12, 6)
        for i in range(6):
            for j in range(6):
                sturm.stiff[rod, i, j] = large[6 + i, 6 + j]
        _go_on(rod, sturm)
    return found


@njit(**INNER)
def _go_on(rod, sturm):
    """Turn stiffness, wrench and frame from the axes at a piece's start to those at its end."""
    turn, frame, wrench = sturm.turn, sturm.frames[rod], sturm.acting[rod]
    for i in range(3):
        for j in range(3):
            turn[i, j] = sturm.state[3 + 3 * j + i]
    turn_stiffness(sturm.stiff[rod], turn, sturm.square)
    for i in range(3):
        x, y, z = frame[i, 0], frame[i, 1], frame[i, 2]
        for j in range(3):
            frame[i, j] = x * turn[0, j] + y * turn[1, j] + z * turn[2, j]
    for first in (0, 3):
        x, y, z = wrench[first], wrench[first + 1], wrench[first + 2]
        for j in range(3):
            wrench[first + j] = x * turn[0, j] + y * turn[1, j] + z * turn[2, j]


@njit(**INNER)
def _cut(wrench, soft, length, ease, turn):
    """Return pieces and integrator steps in each.

    Held at both ends, a piece h is stable if |m| h / pi + |n| h^2 / pi^2 is below its stiffness,
    by Poincare's inequality for phi.
    """
    softest = max(ease, 1.0) * max(soft[0], soft[0] + soft[1])
    n = np.sqrt(wrench[3] ** 2 + wrench[4] ** 2 + wrench[5] ** 2) * softest
    m = np.sqrt(wrench[0] ** 2 + wrench[1] ** 2 + wrench[2] ** 2) * softest + n * length
    u = np.sqrt(soft[2] ** 2 + soft[3] ** 2 + soft[4] ** 2)
    by_moment, by_force = m * length / np.pi, n * (length / np.pi) ** 2
    pieces = 1
    if by_moment + by_force > SAFE:
        root = np.sqrt(by_moment**2 + 4 * SAFE * by_force)
        pieces = min(int((by_moment + root) / (2 * SAFE)) + 1, MOST_PIECES)
    whole = length / pieces * (m + np.sqrt(n) + u)
    return pieces, min(int(whole / turn) + 1, MOST_STEPS)


@njit(**INNER)
def _add_joint(rod, rigid, sturm):
    """Add a snare's stiffness and wrench to the tool's where it grasps; return the negative
    pivots."""
    stiff, tool, turn = sturm.stiff[rod], sturm.stiff[0], sturm.turn
    wrench = sturm.acting[rod]
    for i in range(3):  # the tool's directions in the snare's axes
        for j in range(3):
            turn[i, j] = 0.0
            for k in range(3):
                turn[i, j] += sturm.frames[rod, k, i] * sturm.frames[0, k, j]
    turn_stiffness(stiff, turn, sturm.square)
    for first in (0, 3):
        x, y, z = wrench[first], wrench[first + 1], wrench[first + 2]
        for j in range(3):
            wrench[first + j] = x * turn[0, j] + y * turn[1, j] + z * turn[2, j]
            sturm.acting[0, first + j] += wrench[first + j]
    found = 0
    if not rigid:
        found = free_turns(turn[2], wrench, stiff, sturm.large)
    for i in range(6):
        for j in range(6):
            tool[i, j] += stiff[i, j]
    return found
