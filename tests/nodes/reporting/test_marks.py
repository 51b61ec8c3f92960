"""Marks are held against closed forms by trimesh, which shares no code with them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.reporting.marks import (
    SIDES,
    join_meshes,
    make_arrow,
    make_ball,
    make_needle,
    sweep_line,
    sweep_tube,
)

trimesh = pytest.importorskip("trimesh")
PRISM = SIDES * np.sin(2 * np.pi / SIDES) / (2 * np.pi)  # polygon's area over its circle's

directions = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array).filter(lambda v: np.dot(v, v) > 0.01)


def solid(mesh):
    """Return the mesh with coincident corners made one, as trimesh's tests of closure need it."""
    made = trimesh.Trimesh(mesh.vertices_patient_mm, mesh.triangles)
    made.merge_vertices()
    made.update_faces(made.nondegenerate_faces())
    return made


@settings(max_examples=25, deadline=None)
@given(directions)
def test_a_needle_is_closed_and_has_its_volume_wherever_it_points(direction):
    start = np.array([10.0, -20.0, 300.0])
    needle = solid(make_needle(start, start + direction * 40, 1.0))
    length = 40 * np.linalg.norm(direction)
    tip = max(length - 2, length / 2)
    assert needle.is_watertight
    expected = np.pi * PRISM * (tip + (length - tip) / 3)
    assert needle.volume == pytest.approx(expected, rel=1e-3)


@settings(max_examples=25, deadline=None)
@given(directions)
def test_an_arrow_ends_its_length_away_along_its_direction(direction):
    start = np.array([1.0, 2.0, 3.0])
    arrow = make_arrow(start, direction, 40.0, 1.2)
    unit = direction / np.linalg.norm(direction)
    along = (arrow.vertices_patient_mm - start) @ unit
    assert along.max() == pytest.approx(40, abs=1e-3) and along.min() == pytest.approx(0, abs=1e-3)
    tip = arrow.vertices_patient_mm[along.argmax()]
    assert tip == pytest.approx(start + 40 * unit, abs=1e-3)
    assert solid(arrow).is_watertight and solid(arrow).volume > 0


def test_a_ball_is_closed_outward_and_within_its_radius():
    ball = solid(make_ball(np.array([5.0, 6.0, 7.0]), 3.0))
    assert ball.is_watertight and 0.7 < ball.volume / (4 / 3 * np.pi * 27) < 1
    distances = np.linalg.norm(ball.vertices - [5, 6, 7], axis=1)
    assert distances == pytest.approx(np.full(len(distances), 3), abs=1e-4)


def test_a_needle_of_no_length_is_still_drawn_without_nan():
    mesh = make_needle(np.zeros(3), np.zeros(3), 1.0)
    assert np.isfinite(mesh.vertices_patient_mm).all()


def test_joined_meshes_keep_their_triangles():
    balls = [make_ball(np.array([x, 0.0, 0.0]), 2.0) for x in (0.0, 10.0, 20.0)]
    joined = join_meshes(tuple(balls))
    assert trimesh.Trimesh(joined.vertices_patient_mm, joined.triangles).volume == pytest.approx(
        3 * solid(balls[0]).volume, rel=1e-4
    )


def test_a_tube_along_an_arc_is_closed_and_has_the_torus_part_s_volume():
    turns = np.linspace(0, 1.5, 60)
    points = 40 * np.stack([1 - np.cos(turns), 0 * turns, np.sin(turns)], axis=1)
    tangents = np.stack([np.sin(turns), 0 * turns, np.cos(turns)], axis=1)
    tube = solid(sweep_tube(points, tangents, 2.0))
    assert tube.is_watertight
    assert tube.volume == pytest.approx(np.pi * 4 * PRISM * 60, rel=2e-3)  # Pappus


def test_a_tube_keeps_its_radius_where_the_curve_turns_at_once():
    points = np.array([[0.0, 0, 0], [0, 0, 5], [5, 0, 5]])
    tangents = np.array([[0.0, 0, 1], [0, 0, 1], [1, 0, 0]])
    mesh = sweep_tube(points, tangents, 1.0)
    nearest = np.linalg.norm(mesh.vertices_patient_mm[:, None] - points, axis=2).min(axis=1)
    assert set(np.round(nearest, 5)) == {0.0, 1.0}


def test_a_line_through_points_is_a_closed_tube_of_its_length():
    points = np.array([[0.0, 0, 0], [0, 0, 0], [0, 0, 30], [0, 0, 100]])
    tube = solid(sweep_line(points, 2.0))
    assert tube.is_watertight
    assert tube.volume == pytest.approx(100 * np.pi * 2**2 * PRISM, rel=1e-3)


def test_a_line_that_turns_back_or_never_moves_is_no_error():
    back = sweep_line(np.array([[0.0, 0, 0], [0, 0, 10], [0, 0, 0]]), 1.0)
    assert np.isfinite(back.vertices_patient_mm).all()
    assert not len(sweep_line(np.zeros((3, 3)), 1.0).triangles)
