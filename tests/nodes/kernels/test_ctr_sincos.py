"""Sine and cosine against numpy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodes.kernels.ctr_sincos import sincos


@pytest.mark.parametrize("call", [sincos, sincos.py_func], ids=["compiled", "python"])
@given(st.floats(-1e4, 1e4))
def test_sine_and_cosine_are_exact(call, angle):
    np.testing.assert_allclose(call(angle), (np.sin(angle), np.cos(angle)), rtol=0, atol=2e-15)


def test_all_quadrants_have_their_signs():
    for quarter in range(-9, 10):
        angle = quarter * np.pi / 2 + 0.3
        np.testing.assert_allclose(sincos(angle), (np.sin(angle), np.cos(angle)), atol=2e-15)


def test_what_is_no_number_stays_none():
    assert np.isnan(sincos(np.nan)).all()
