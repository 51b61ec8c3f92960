"""Sine and cosine of floats and of lanes against numpy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from nodes.kernels.ctr_lanes import LANES, load_rows, make_steps, store_rows
from nodes.kernels.ctr_sincos import sincos


@njit
def of_float(angle):
    return sincos(angle)


@njit
def _of_lanes(lanes):
    (angle,) = load_rows((0.0,), lanes, 0)
    store_rows(sincos(angle), lanes, 1)


def of_lanes(angle):
    """The same of eight angles, of which the last is the one asked for."""
    lanes = make_steps(3)
    lanes[0] = angle + np.arange(1 - LANES, 1)
    _of_lanes(lanes)
    np.testing.assert_allclose(lanes[1:], [np.sin(lanes[0]), np.cos(lanes[0])], rtol=0, atol=2e-15)
    return lanes[1, -1], lanes[2, -1]


both = pytest.mark.parametrize("call", [of_float, of_lanes])


@both
@given(st.floats(-1e4, 1e4))
def test_sine_and_cosine_are_exact(call, angle):
    np.testing.assert_allclose(call(angle), (np.sin(angle), np.cos(angle)), rtol=0, atol=2e-15)


@both
def test_all_quadrants_have_their_signs(call):
    for quarter in range(-9, 10):
        angle = quarter * np.pi / 2 + 0.3
        np.testing.assert_allclose(call(angle), (np.sin(angle), np.cos(angle)), atol=2e-15)


def test_what_is_no_number_stays_none():
    assert np.isnan(of_float(np.nan)).all()
