"""One step of torsion against Jacobi's elliptic functions: two tubes are a pendulum."""

import numpy as np
import pytest
from numba import njit
from scipy.special import ellipj, ellipk

from nodes.kernels.ctr_torsion import step_order_4, step_order_8


@njit
def step_8(size, share, drive, h, state, rate):
    return step_order_8(size, share, drive, h, state, rate)


@njit
def step_4(size, share, drive, h, state, rate):
    return step_order_4(size, share, drive, h, state, rate)


def pendulum(apart, wave, way):
    """phi'' = w^2 sin(phi) from rest at `apart`."""
    m = np.cos(apart / 2) ** 2
    sine, cosine, delta, _ = ellipj(wave * way + ellipk(m), m)
    rate = -2 * np.sqrt(m) * wave * cosine * delta / np.sqrt(1 - m * sine**2)
    return np.pi - 2 * np.arcsin(np.sqrt(m) * sine), rate


@pytest.mark.parametrize(("step", "order"), [(step_4, 4), (step_8, 8)])
def test_a_step_has_at_least_its_order(step, order):
    # w^2 = drive_2 share_1 + drive_1 share_2
    share, drive = (0.004, 0.006), (0.01, 0.05)
    wave = np.sqrt(0.05 * 0.004 + 0.01 * 0.006)
    errors = []
    for h in (80.0, 40.0):
        state, rate = step((0.0,), share, drive, -h, (1.3, 1.0), (0.0, 0.0))
        exact, exact_rate = pendulum(1.3, wave, h)
        ahead, _ = pendulum(1.3 + 1e-6, wave, h)
        errors.append(abs(state[0] - exact))
        assert rate[0] == pytest.approx(-exact_rate, abs=20 * errors[-1] * wave + 1e-15)
        assert state[1] == pytest.approx((ahead - exact) / 1e-6, abs=10 * errors[-1] + 2e-6)
    assert errors[0] / errors[1] > 2 ** (order + 1)
    assert errors[1] < (1e-3 if order == 4 else 2e-8)
