"""Follow the equilibria of a CRISP robot while its needles move, however sharply, up to a fold.

Unknown are the share of the motion and the wrenches in axes that turn with the needles' bases, for
a taut needle that is turned as a whole with its wrench stays bent as it is. From each point found
the next guess lies on the tangent to the curve of equilibria, and Newton's method leads from there
back to the curve, across the tangent [Keller1977]. Where the share ceases to grow the curve turns
back: this branch has no equilibrium beyond, its stability margin falls to 0 there, and the robot
snaps to another.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.crisp_general_problem import ARC, LENGTH, Packed
from nodes.kernels.crisp_general_solve import (
    NO_SOLUTION,
    NOT_CONVERGED,
    SOLVED,
    Newton,
    aim,
    measure,
    measure_rows,
    new_newton,
    set_weights,
    step_reach,
)
from nodes.kernels.crisp_linear import factorise, solve_factorised

FIRST, NARROW = 0.05, 1e-7  # first and least step along the curve; 1 bends a needle by a radian
LONGER, SHORTER = 1.7, 0.4  # what becomes of a step after an easy one, and after a failed one
EASY, STRAIGHT = 0.995, 0.97  # cosine between tangents, of an easy step and of the sharpest allowed
ASIDE = 0.3  # of a step: where Newton's method leads further from the tangent it may have jumped
ROUGH = 1e-4  # mm, what the integration may be off by; who takes the end as a guess mends that
CORRECTIONS = 6  # of Newton's method at one point
CLOSE = 1e-6  # a correction after which the next one would be lost in rounding
POINTS = 400  # on a curve
NUDGE = 1e-5  # share by which the motion's effect on the residual is measured


class Piece(NamedTuple):
    """A motion: turns (n, 3) rotation vectors of the needles, growths (n,) of their lengths and
    slides (k,) of the grasps' arc lengths, mm."""

    turns: np.ndarray
    growths: np.ndarray
    slides: np.ndarray


class Curve(NamedTuple):
    """Workspace.

    start, now : Packed, at share 0 and where the evaluation stands.
    newton : Newton.
    wrench, units : (n, 6) of the evaluation, and what counts as 1 of each.
    turns : (n, 3, 3) rotations of the bases since the start.
    here, trial, tangent, across : (6 n + 1,) points and directions: turned wrenches in units, then
        the share.
    slope : (6 n,) of the residual by the share, mm.
    matrix, order, right : (6 n + 1, 6 n + 1), (6 n + 1,), (6 n + 1,) of a linear system.
    """

    start: Packed
    now: Packed
    newton: Newton
    wrench: np.ndarray
    units: np.ndarray
    turns: np.ndarray
    here: np.ndarray
    trial: np.ndarray
    tangent: np.ndarray
    across: np.ndarray
    slope: np.ndarray
    matrix: np.ndarray
    order: np.ndarray
    right: np.ndarray


@njit(cache=True, nogil=True, error_model="numpy")
def follow_branch(crisp, piece, wrench):
    """Follow one equilibrium along a motion.

    Parameters
    ----------
    crisp : Packed, at the start of the motion.
    wrench : (n, 6) moment and force at the bases, of an equilibrium at the start; changed in place
        to that at the end if that is reached.

    Returns
    -------
    Status, NO_SOLUTION where the branch ends in a fold, and the largest share that was reached.
    """
    curve = _new_curve(crisp, wrench)
    reach, last = step_reach(crisp, ROUGH), wrench.size
    curve.trial[:], curve.across[last] = curve.here, 1.0
    if not _correct(piece, reach, np.inf, curve):
        return NOT_CONVERGED, 0.0
    curve.here[:] = curve.trial
    _turn_tangent(curve)
    stride, furthest = FIRST, 0.0
    for _ in range(POINTS):
        here, tangent = curve.here, curve.tangent
        is_end = here[last] + stride * tangent[last] >= 1.0
        if is_end:
            stride = (1.0 - here[last]) / tangent[last]
        _step_ahead(stride, is_end, curve)
        straight = -1.0
        if _correct(piece, reach, ASIDE * stride, curve):
            straight = _turn_tangent(curve)
        if straight < STRAIGHT:
            stride *= SHORTER
            if stride < NARROW:
                break
            continue
        furthest = max(furthest, curve.trial[last])
        here[:] = curve.trial
        if is_end:
            _read_wrench(here, curve, wrench)
            return SOLVED, 1.0
        if tangent[last] <= 0.0:
            return NO_SOLUTION, furthest
        if straight > EASY:
            stride *= LONGER
    return NOT_CONVERGED, furthest


@njit(cache=True, nogil=True, error_model="numpy")
def _new_curve(crisp, wrench):
    size, units = wrench.size + 1, np.empty(wrench.shape)
    here = np.zeros(size)
    for rod in range(len(units)):
        for i in range(6):
            length = crisp.bases[rod, LENGTH]
            units[rod, i] = 1.0 / (crisp.soft[rod, 0] * (length if i < 3 else length * length))
            here[6 * rod + i] = wrench[rod, i] / units[rod, i]
    newton = new_newton(crisp)
    set_weights(crisp, newton)
    aim(newton, newton.target, 0.0)
    now = Packed(crisp.soft, crisp.bases.copy(), crisp.joints.copy(), crisp.loads)
    return Curve(
        crisp, now, newton, wrench.copy(), units, np.zeros((len(units), 3, 3)), here,
        np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size - 1),
        np.zeros((size, size)), np.zeros(size, np.int64), np.zeros(size),
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def _step_ahead(stride, is_end, curve):
    """Write the trial point, and across what it shall stay: the tangent, at the end the share."""
    for i in range(len(curve.here)):
        curve.trial[i] = curve.here[i] + stride * curve.tangent[i]
        curve.across[i] = 0.0 if is_end else curve.tangent[i]
    if is_end:
        curve.across[-1] = 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _correct(piece, reach, aside, curve):
    """Lead the trial point to the curve, square to `across`; return whether that succeeded.

    The matrix is left factorised.
    """
    trial, right, last = curve.trial, curve.right, len(curve.slope)
    weights, residual = curve.newton.weights, curve.newton.walk.residual
    past = np.inf
    for _ in range(CORRECTIONS):
        _find_slope(piece, reach, curve)
        _move_to(piece, trial[last], curve)
        measure_rows(curve.now, curve.wrench, reach, curve.newton)
        if not _border(curve):
            return False
        for i in range(last):
            right[i] = -weights[i] * residual[i]
        right[last] = 0.0
        solve_factorised(curve.matrix, curve.order, right)
        change = 0.0
        for i in range(last + 1):
            trial[i] += right[i]
            change += abs(right[i])
        if change < CLOSE:
            return True
        if not change < min(0.5 * past, aside):
            return False
        past = change
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_tangent(curve):
    """Turn the tangent into that at the trial point; return the cosine between both."""
    right, last, size, turned = curve.right, len(curve.slope), 0.0, 0.0
    for i in range(last):
        right[i] = 0.0
    right[last] = 1.0
    solve_factorised(curve.matrix, curve.order, right)
    for i in range(last + 1):
        size += right[i] * right[i]
        turned += right[i] * curve.tangent[i]
    size = np.sqrt(size)
    is_first = turned == 0.0
    if turned / size < STRAIGHT and not is_first:
        return turned / size
    for i in range(last + 1):
        curve.tangent[i] = right[i] / size
    return turned / size


@njit(cache=True, nogil=True, error_model="numpy")
def _border(curve):
    """Factorise the derivatives of residual and of the step across by wrenches and share."""
    matrix, last, units = curve.matrix, len(curve.slope), curve.units
    weights, rows = curve.newton.weights, curve.newton.walk.rows
    for i in range(last):
        for column in range(last):
            rod, first, axis = column // 6, column - column % 3, column % 3
            total = 0.0
            for j in range(3):
                total += rows[i, first + j] * curve.turns[rod, j, axis]
            matrix[i, column] = weights[i] * units[rod, column % 6] * total
        matrix[i, last] = curve.slope[i]
    for column in range(last + 1):
        matrix[last, column] = curve.across[column]
    return factorise(matrix, curve.order)


@njit(cache=True, nogil=True, error_model="numpy")
def _find_slope(piece, reach, curve):
    """Write how the residual of the trial point changes with the share."""
    weights, residual = curve.newton.weights, curve.newton.walk.residual
    share, last = curve.trial[-1], len(curve.slope)
    _move_to(piece, share - NUDGE, curve)
    measure(curve.now, curve.wrench, reach, curve.newton)
    for i in range(last):
        curve.slope[i] = -residual[i]
    _move_to(piece, share + NUDGE, curve)
    measure(curve.now, curve.wrench, reach, curve.newton)
    for i in range(last):
        curve.slope[i] = weights[i] * (curve.slope[i] + residual[i]) / (2 * NUDGE)


@njit(cache=True, nogil=True, error_model="numpy")
def _move_to(piece, share, curve):
    """Set the robot to a share of the motion, and to it the trial point's wrenches."""
    _place(curve.start, piece, share, curve.turns, curve.now)
    _read_wrench(curve.trial, curve, curve.wrench)


@njit(cache=True, nogil=True, error_model="numpy")
def _read_wrench(point, curve, wrench):
    """Write the wrenches of a point in world axes, the robot placed at its share."""
    for rod in range(len(wrench)):
        for i in range(6):
            first = i - i % 3
            wrench[rod, i] = 0.0
            for j in range(3):
                own = point[6 * rod + first + j] * curve.units[rod, i]
                wrench[rod, i] += curve.turns[rod, i - first, j] * own


@njit(cache=True, nogil=True, error_model="numpy")
def _place(start, piece, share, turns, now):
    """Write the robot at a share of the motion, and how its bases are turned there."""
    for rod in range(len(start.bases)):
        now.bases[rod, LENGTH] = start.bases[rod, LENGTH] + share * piece.growths[rod]
        _rotate(piece.turns[rod], share, turns[rod])
        for axis in range(3, 12, 3):
            for i in range(3):
                now.bases[rod, axis + i] = 0.0
                for j in range(3):
                    now.bases[rod, axis + i] += turns[rod, i, j] * start.bases[rod, axis + j]
    for joint in range(len(start.joints)):
        now.joints[joint, ARC] = start.joints[joint, ARC] + share * piece.slides[joint]


@njit(cache=True, nogil=True, error_model="numpy")
def _rotate(vector, share, rotation):
    """Write the rotation by a share of a rotation vector, after Rodrigues."""
    angle = share * np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    sine, rest = share, 0.0
    if angle != 0.0:
        sine, rest = share * np.sin(angle) / angle, 2.0 * (share * np.sin(0.5 * angle) / angle) ** 2
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        rotation[i, i] = np.cos(angle) + rest * vector[i] ** 2
        rotation[i, j] = rest * vector[i] * vector[j] - sine * vector[k]
        rotation[j, i] = rest * vector[i] * vector[j] + sine * vector[k]
