"""Pieces of rods against closed forms, finite differences and finer steps."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from nodes.kernels.crisp_rod import bend_full, bend_pose, count_steps

BENDING, TORSION = 1435.0, 1079.0


def at_rest(turn=None):
    state = np.zeros(48)
    state[3:12] = np.eye(3).ravel() if turn is None else turn.T.ravel()
    return state


def soft(precurvature=(0.0, 0.0, 0.0)):
    return np.array([1 / BENDING, 1 / TORSION - 1 / BENDING, *precurvature])


def bent(wrench, length, precurvature=(0.0, 0.0, 0.0), steps=12, turn=None):
    state, wrench = at_rest(turn), np.array(wrench, float)
    bend_pose(state, wrench, soft(precurvature), length, steps, np.zeros((14, 48)))
    return state, wrench


def axes(state):
    return state[3:12].reshape(3, 3).T


def random_rod(seed):
    chance = np.random.default_rng(seed)
    length = chance.uniform(20, 300)
    moment = chance.normal(size=3) * BENDING * 10 ** chance.uniform(-4, -1.8)
    force = chance.normal(size=3) * BENDING / length**2 * 10 ** chance.uniform(-1, 1)
    precurvature = chance.normal(size=3) * chance.choice([0, 0.005])
    return np.concatenate([moment, force]), length, precurvature


def test_moment_alone_bends_to_an_arc_and_twists():
    state, wrench = bent([0, BENDING * 0.01, 0, 0, 0, 0], 100.0)
    assert state[:3] == pytest.approx([(1 - np.cos(1)) * 100, 0, np.sin(1) * 100], abs=1e-10)
    assert wrench[:3] == pytest.approx([0, BENDING * 0.01, 0])
    state, _ = bent([0, 0, TORSION * 0.02, 0, 0, 0], 50.0)
    assert axes(state) == pytest.approx(Rotation.from_rotvec([0, 0, 1.0]).as_matrix(), abs=1e-12)
    assert state[:3] == pytest.approx([0, 0, 50], abs=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_rod_is_what_scipy_integrates(seed):
    wrench, length, precurvature = random_rod(seed)
    turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    inverse = np.diag([1 / BENDING, 1 / BENDING, 1 / TORSION])

    def slope(_, y):
        frame, moment = y[3:12].reshape(3, 3), y[12:]
        rate = frame @ (precurvature + inverse @ frame.T @ moment)
        spin = np.cross(rate, frame, axis=0, axisb=0, axisc=0)
        return np.concatenate([frame[:, 2], spin.ravel(), -np.cross(frame[:, 2], wrench[3:])])

    start = np.concatenate([np.zeros(3), turn.ravel(), wrench[:3]])
    slow = solve_ivp(slope, (0, length), start, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    state, after = bent(wrench, length, precurvature, 24, turn)
    assert state[:3] == pytest.approx(slow[:3], abs=1e-8)
    assert axes(state) == pytest.approx(slow[3:12].reshape(3, 3), abs=1e-9)
    assert after[:3] == pytest.approx(slow[12:], abs=1e-7)


@pytest.mark.parametrize("seed", range(6))
def test_columns_are_finite_differences(seed):
    wrench, length, precurvature = random_rod(seed)
    state, moved = at_rest(), wrench.copy()
    bend_full(state, moved, soft(precurvature), 1.0, length, 24, np.zeros((14, 48)))
    plain, after = bent(wrench, length, precurvature, 24)
    assert np.abs(state[:12] - plain[:12]).max() < 1e-12 and np.abs(moved - after).max() < 1e-12
    exact = state[12:].reshape(6, 6)
    for column, unit in enumerate(np.repeat([BENDING / length, BENDING / length**2], 3)):
        ends = [
            bent(wrench + sign * 1e-5 * unit * np.eye(6)[column], length, precurvature, 24)[0]
            for sign in (1, -1)
        ]
        turn = Rotation.from_matrix(axes(ends[0]) @ axes(ends[1]).T).as_rotvec()
        slope = np.concatenate([ends[0][:3] - ends[1][:3], length * turn]) / 2e-5
        wanted = exact[:, column] * unit * np.repeat([1, length], 3)
        assert slope == pytest.approx(wanted, abs=1e-6 * np.abs(wanted).max())


def test_softer_columns_belong_to_a_softer_rod_where_nothing_pulls():
    state, same = at_rest(), np.zeros(6)
    bend_full(state, same, soft((0.004, 0.0, 0.002)), 3.0, 80.0, 6, np.zeros((14, 48)))
    soft_columns = state[12:].copy()
    bend_full(state := at_rest(), same, soft((0.004, 0, 0.002)), 1.0, 80.0, 6, np.zeros((14, 48)))
    assert soft_columns == pytest.approx(3 * state[12:], rel=1e-12, abs=1e-15)


def test_counted_steps_keep_the_error_that_they_promise():
    errors = []
    for seed in range(200):
        wrench, length, precurvature = random_rod(seed)
        steps = count_steps(wrench, soft(precurvature), length, (4e6 * 1e-6 / length) ** 0.125)
        rough, fine = (bent(wrench, length, precurvature, n)[0] for n in (steps, 3 * steps + 8))
        errors.append(np.abs(rough[:3] - fine[:3]).max())
    # 4e6 of 1e-7 for half of them and of 2e-6 for 99 of 100, as the count says.
    assert np.quantile(errors, 0.5) < 0.4e-6 and np.quantile(errors, 0.99) < 8e-6
    assert np.quantile(errors, 0.5) > 1e-10  # nor are steps wasted


def test_diverged_wrench_still_takes_a_bounded_number_of_steps():
    assert count_steps(np.full(6, np.nan), soft(), 100.0, 0.5) == 64
    assert count_steps(np.full(6, np.inf), soft(), 100.0, 0.5) == 64
