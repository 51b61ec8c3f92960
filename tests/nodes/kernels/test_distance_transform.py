"""Sweeps against brute force over all faces of a line, compiled and as plain Python."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nodes.kernels.distance_transform import sweep

LINES = arrays(bool, st.integers(1, 9))


def brute_force(mask, heights, step):
    """Each cell sees the boxes of its row: those of the other kind at 0, its own kind's heights."""
    lowest = np.empty(len(mask))
    for i, kind in enumerate(mask):
        lowest[i] = heights[i]
        for j in range(-1, len(mask) + 1):
            beyond = not 0 <= j < len(mask)
            gap = max(abs(i - j) - 0.5, 0) * step
            if (False if beyond else mask[j]) != kind:
                lowest[i] = min(lowest[i], gap**2)
            elif not beyond:
                lowest[i] = min(lowest[i], heights[j] + gap**2)
    return lowest


@pytest.mark.parametrize("call", [sweep, sweep.py_func], ids=["compiled", "python"])
@settings(max_examples=60, deadline=None)
@given(LINES, st.integers(0, 99), st.sampled_from([0.5, 1.0, 1.7]))
def test_a_sweep_finds_the_lowest_of_all_parabolas(call, mask, seed, step):
    heights = np.random.default_rng(seed).uniform(0, 9, len(mask)).astype(np.float32)
    lines = heights.reshape(1, -1, 1).copy()
    call(lines, mask.reshape(1, -1, 1), step, False, 0, 1)
    np.testing.assert_allclose(lines[0, :, 0], brute_force(mask, heights, step), rtol=1e-6)


@settings(max_examples=30, deadline=None)
@given(LINES)
def test_the_first_sweep_reads_nothing_and_knows_only_faces(mask):
    lines = np.full((1, len(mask), 1), -7, np.float32)
    sweep(lines, mask.reshape(1, -1, 1), 1.0, True, 0, 1)
    expected = brute_force(mask, np.full(len(mask), np.inf), 1.0)
    np.testing.assert_allclose(lines[0, :, 0], expected, rtol=1e-6)


def test_parts_of_the_work_cover_all_lines_once():
    rng = np.random.default_rng(0)
    mask, heights = rng.random((3, 5, 37)) < 0.5, rng.random((3, 5, 37)).astype(np.float32)
    whole, shared = heights.copy(), heights.copy()
    sweep(whole, mask, 1.0, False, 0, 1)
    for part in (2, 0, 1):
        sweep(shared, mask, 1.0, False, part, 3)
    np.testing.assert_array_equal(whole, shared)
