"""The Jacobian against finite differences of the residual, away from any solution."""

import numpy as np
import pytest
from numba import njit

from nodes.kernels.crisp_lanes import make_lanes, store
from nodes.kernels.crisp_straight_jacobian import find_jacobian
from nodes.kernels.crisp_straight_residual import find_residual
from tests.nodes.kernels.crisp_straight_case import random_robot


@njit(cache=True)
def residual_of(robot, pose, wrenches, residual, steps, work, total):
    store(total, 0, find_residual(robot, pose, wrenches, residual, steps, work))


@njit(cache=True)
def jacobian_of(robot, pose, wrenches, residual, jacobian, columns, moves, steps, work):
    find_jacobian(robot, pose, wrenches, residual, jacobian, columns, moves, steps, work)


@pytest.mark.parametrize(
    "rigid", [[False], [True], [False, True], [True, False, False]], ids=lambda r: f"{r}"
)
def test_jacobian_is_the_derivative_of_the_residual(rigid):
    robot, pose, wrenches, work = random_robot(4, rigid)
    count, steps = len(wrenches), np.full(2 * len(rigid), 8)
    here, jacobian = make_lanes(count), make_lanes(count * count)
    jacobian_of(
        robot, pose, wrenches, here, jacobian, make_lanes(36), make_lanes(6 * count), steps, work
    )
    ends, total, step = [make_lanes(count), make_lanes(count)], make_lanes(1), 1e-5
    for column in range(count):
        for sign, end in zip((1, -1), ends, strict=True):
            moved = make_lanes(count)
            moved[:] = wrenches
            moved[column] += sign * step
            residual_of(robot, pose, moved, end, steps, work, total)
        change = (ends[0] - ends[1]) / (2 * step)
        exact = jacobian.reshape(count, count, -1)[:, column]
        assert (np.abs(exact - change) < 1e-6 * (1 + np.abs(change) + np.abs(here))).all()


def test_the_returned_total_is_the_sum_of_magnitudes():
    robot, pose, wrenches, work = random_robot(1, [True, False])
    residual, total = make_lanes(len(wrenches)), make_lanes(1)
    residual_of(robot, pose, wrenches, residual, np.full(4, 3), work, total)
    assert np.abs(total[0] - np.abs(residual).sum(0)).max() < 1e-12
