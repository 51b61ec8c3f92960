"""Inverses of the Jacobians of straight CRISP robots, in lanes."""

from numba import njit

from nodes.kernels.crisp_lanes import LANES, load, spread, store
from nodes.kernels.crisp_straight_jacobian import find_jacobian

COARSER = 3  # how much longer the steps are from which Jacobians are made


@njit(cache=True, nogil=True, error_model="numpy")
def renew_inverse(robot, pose, wrenches, alive, steps, solver, work):
    """Write the inverse of the Jacobian of lanes that are alive."""
    _renew_jacobian(robot, pose, wrenches, steps, solver, work)
    store(solver.columns, 0, alive)
    invert_lanes(solver.jacobian, solver.columns[0], solver.inverse, solver.signs, solver.square)


@njit(cache=True, nogil=True, error_model="numpy")
def polish_inverse(robot, pose, wrenches, steps, solver, work):
    """Turn an inverse B that is nearly right into that of the Jacobian J here: B <- B (2 - J B)
    [Schulz1933]."""
    _renew_jacobian(robot, pose, wrenches, steps, solver, work)
    count = len(wrenches)
    product, old = solver.product, solver.inverse
    for row in range(count):
        for column in range(count):
            total = spread(2.0 if row == column else 0.0)
            for inner in range(count):
                total = total - load(solver.jacobian, row * count + inner) * load(
                    old, inner * count + column
                )
            store(product, row * count + column, total)
    for row in range(count):
        for column in range(count):
            total = spread(0.0)
            for inner in range(count):
                total = total + load(old, row * count + inner) * load(
                    product, inner * count + column
                )
            store(solver.jacobian, row * count + column, total)
    old[:] = solver.jacobian


@njit(cache=True, nogil=True, error_model="numpy")
def _renew_jacobian(robot, pose, wrenches, steps, solver, work):
    """Write a Jacobian from fewer, longer steps: right to some 1e-5, which iterations forgive."""
    for rod in range(len(steps)):
        solver.steps[rod] = (steps[rod] + COARSER - 1) // COARSER
    find_jacobian(
        robot, pose, wrenches, solver.before, solver.jacobian, solver.columns, solver.moves,
        solver.steps, work,
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def invert_lanes(matrices, wanted, inverses, signs, square):
    """Write the inverse of each wanted lane's matrix; a singular one gives inf or nan.

    Parameters
    ----------
    matrices, inverses : (n^2, LANES).
    wanted : (LANES,) 0 where it is not.
    signs : (LANES,), written: of the determinants.
    square : (n, 2 n), overwritten.
    """
    count = len(square)
    for lane in range(LANES):
        if wanted[lane] == 0:
            continue
        for row in range(count):
            for column in range(count):
                square[row, column] = matrices[row * count + column, lane]
                square[row, count + column] = 1.0 if row == column else 0.0
        signs[lane] = _eliminate(square)
        for row in range(count):
            for column in range(count):
                inverses[row * count + column, lane] = square[row, count + column]


@njit(cache=True, nogil=True, error_model="numpy")
def _eliminate(square):
    """Turn (A, 1) into (1, inverse of A) by Gauss and Jordan with the largest pivot of a column;
    return the sign of A's determinant."""
    count, sign = len(square), 1.0
    for pivot in range(count):
        best = pivot
        for row in range(pivot + 1, count):
            if abs(square[row, pivot]) > abs(square[best, pivot]):
                best = row
        for column in range(2 * count):
            square[pivot, column], square[best, column] = (
                square[best, column],
                square[pivot, column],
            )
        if (square[pivot, pivot] < 0.0) != (best != pivot):
            sign = -sign
        factor = 1.0 / square[pivot, pivot]
        for column in range(pivot, 2 * count):
            square[pivot, column] *= factor
        for row in range(count):
            if row != pivot:
                factor = square[row, pivot]
                for column in range(pivot, 2 * count):
                    square[row, column] -= factor * square[pivot, column]
    return sign


@njit(cache=True, nogil=True, error_model="numpy")
def find_signs(robot, pose, wrenches, wanted, signs, steps, solver, work):
    """Write the signs of the Jacobian's determinant of wanted lanes.

    Between two solutions of different signs a branch folds, or they are not on one branch
    [Keller1977].
    """
    _renew_jacobian(robot, pose, wrenches, steps, solver, work)
    store(solver.columns, 0, wanted)
    square, count = solver.square, len(solver.square)
    for lane in range(LANES):
        if solver.columns[0, lane] != 0:
            for row in range(count):
                for column in range(count):
                    square[row, column] = solver.jacobian[row * count + column, lane]
            signs[lane] = _find_sign(square)


@njit(cache=True, nogil=True, error_model="numpy")
def _find_sign(square):
    """Return the sign of the determinant of the left half, which is overwritten."""
    count, sign = len(square), 1.0
    for pivot in range(count):
        best = pivot
        for row in range(pivot + 1, count):
            if abs(square[row, pivot]) > abs(square[best, pivot]):
                best = row
        if (square[best, pivot] < 0.0) != (best != pivot):
            sign = -sign
        factor = 1.0 / square[best, pivot]
        for column in range(pivot, count):
            square[pivot, column], square[best, column] = (
                square[best, column],
                square[pivot, column],
            )
        for row in range(pivot + 1, count):
            share = factor * square[row, pivot]
            for column in range(pivot + 1, count):
                square[row, column] -= share * square[pivot, column]
    return sign
