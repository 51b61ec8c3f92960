"""Gaps between needles are lower bounds, near to the closest of dense samples."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.optimize import minimize

from nodes.planning.checking_needles import _between_lines, measure_gaps
from nodes.planning.checking_shapes import Course
from tests.nodes.planning.made_motions import NEEDLE, PARAMETERS, SETUP

CORNERS = hnp.arrays(float, (4, 3), elements=st.integers(-4, 4).map(float))


def line(start, end, count=31) -> Course:
    """A straight needle, standing still or moving, (c, 3) ends."""
    start, end = np.atleast_2d(start).astype(float), np.atleast_2d(end).astype(float)
    shares = np.linspace(0, 1, count)
    lengths = np.linalg.norm(end - start, axis=1)
    points = start[:, None] + shares[:, None] * (end - start)[:, None]
    ways = ((end - start) / lengths[:, None])[:, None].repeat(count, axis=1)
    return Course(lengths[:, None] * shares, points, ways)


def gap(*courses: Course) -> np.ndarray:
    (found,) = measure_gaps(SETUP, courses, PARAMETERS)
    return found.least_mm


@settings(max_examples=100, deadline=None)
@given(CORNERS)
def test_distance_of_lines_is_the_least_over_both(corners) -> None:
    a, b, c, d = corners
    grid = np.linspace(0, 1, 41)
    one, other = a + grid[:, None] * (b - a), c + grid[:, None] * (d - c)
    away = np.linalg.norm(one[:, None] - other, axis=2)
    start = np.unravel_index(np.argmin(away), away.shape)
    best = minimize(
        lambda u: np.sum((a + u[0] * (b - a) - c - u[1] * (d - c)) ** 2),
        [grid[start[0]], grid[start[1]]], bounds=[(0, 1), (0, 1)], options={"ftol": 1e-15},
    )  # fmt: skip
    found = _between_lines(*(corner[None] for corner in corners))[0]
    assert found == pytest.approx(np.sqrt(best.fun), abs=1e-4)
    assert found <= away.min() + 1e-12


def test_the_gap_is_less_both_radii_and_leaves_out_the_grasp() -> None:
    tool, snare = line((0, 0, 0), (0, 0, 70)), line((60, 0, 60), (0, 0, 60))
    assert gap(tool, snare)[0] == pytest.approx(PARAMETERS.grasp_mm - NEEDLE.outer_diameter_mm)
    beside = line((60, 3, 60), (-60, 3, 60), count=61)
    assert gap(tool, beside)[0] == pytest.approx(3 - NEEDLE.outer_diameter_mm)


def test_bent_needles_are_nowhere_nearer_than_told() -> None:
    angles = np.linspace(0, 1.5, 41)
    bend = np.column_stack([40 - 40 * np.cos(angles), 0 * angles, 40 * np.sin(angles)])
    ways = np.column_stack([np.sin(angles), 0 * angles, np.cos(angles)])
    tool = Course(40 * angles[None], bend[None], ways[None])
    snare = line((30, 4, 10), (5, 4, 45), count=23)
    fine = np.linspace(0, 1.5, 3001)
    dense = np.column_stack([40 - 40 * np.cos(fine), 0 * fine, 40 * np.sin(fine)])
    share = np.linspace(0, 1 - PARAMETERS.grasp_mm / snare.arcs_mm[0, -1], 2001)[:, None]
    others = np.array([30, 4, 10]) + share * np.array([-25, 0, 35])
    wanted = min(np.linalg.norm(others - point, axis=1).min() for point in dense)
    found = gap(tool, snare)[0] + NEEDLE.outer_diameter_mm
    assert wanted - 0.05 < found <= wanted + 1e-6


def test_needles_that_swap_sides_between_configurations_are_told() -> None:
    tool = line([(0, 0, 0)] * 2, [(0, 0, 70)] * 2)
    snare = line([(60, 2, 40), (60, -2, 40)], [(-30, 2, 40), (-30, -2, 40)], count=41)
    assert (gap(tool, snare) < 0).all()
    slow = line([(60, 2, 40), (60, 1.8, 40)], [(-30, 2, 40), (-30, 1.8, 40)], count=41)
    assert gap(tool, slow) == pytest.approx([2 - 0.1 - 1.02, 1.8 - 0.1 - 1.02])


def test_two_snares_have_no_grasp_to_leave_out() -> None:
    setup = replace(
        SETUP, needles=(NEEDLE,) * 3, entry_points_patient_mm=np.diag([99.0, 99, 99]),
        snares=(SETUP.snares[0], replace(SETUP.snares[0], needle=2)),
    )  # fmt: skip
    tool = line((0, 0, 0), (0, 0, 70))
    snares = line((60, 0, 60), (1, 0, 60)), line((60, 9, 60), (1, 0.5, 60))
    gaps = {
        found.needles: found.least_mm[0]
        for found in measure_gaps(setup, (tool, *snares), PARAMETERS)
    }
    assert set(gaps) == {(0, 1), (0, 2), (1, 2)}
    assert gaps[1, 2] == pytest.approx(0.5 * 59 / np.hypot(59, 8.5) - 1.02, abs=1e-2)
