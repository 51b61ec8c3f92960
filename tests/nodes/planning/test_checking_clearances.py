"""Clearances are lower bounds, near to what closed forms and dense samples say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.planning.checking_boxes import make_boxes
from nodes.planning.checking_clearances import measure_clearances
from nodes.planning.checking_shapes import Course
from tests.nodes.planning.made_motions import HIGH, LOW, PARAMETERS, around, box_grid

RADIUS = 0.51


def boxes_of(grid):
    return make_boxes(~grid.mask("free"), grid.patient_from_index, outside=True)


def straight(entry, ways, length=60.0, spacing=2.0) -> Course:
    """A straight needle that points along each way, one after the other."""
    ways = np.array(ways, float) / np.linalg.norm(ways, axis=-1, keepdims=True)
    held = min(PARAMETERS.sheath_mm, length)
    arcs = np.concatenate([
        np.linspace(0, held, round(held / spacing) + 1)[:-1],
        np.linspace(held, length, max(round((length - held) / spacing), 1) + 1),
    ])  # fmt: skip
    points = np.array(entry, float) + arcs[:, None] * ways[:, None]
    return Course(np.tile(arcs, (len(ways), 1)), points, np.repeat(ways[:, None], len(arcs), 1))


def box_clearances(points: np.ndarray) -> np.ndarray:
    """Distances to the walls of the free box of `box_grid`, closed form."""
    return np.minimum(points - LOW, HIGH - points).min(axis=-1) - RADIUS


@settings(max_examples=30, deadline=None)
@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-20, 40), st.floats(20, 110))
def test_in_a_box_clearance_is_the_distance_to_its_walls(x, y, at, length) -> None:
    course = straight((at, 0, 0), [[x, y, 1]], length)
    found = measure_clearances(course, RADIUS, BOX, PARAMETERS)
    fine = straight((at, 0, 0), [[x, y, 1]], length, 0.02)
    beyond = fine.arcs_mm[0] >= PARAMETERS.sheath_mm
    # Within the wall nothing is told but that it is touched.
    wanted = max(box_clearances(fine.points[0][beyond]).min(), -RADIUS)
    assert found.least_mm[0] <= wanted + 1e-9
    assert found.least_mm[0] >= wanted - 2 * PARAMETERS.accuracy_mm


BOX = boxes_of(box_grid())


def test_in_a_ball_of_cells_clearance_is_that_of_dense_samples() -> None:
    """A bent needle in a ball of 30 mm, cut into cells of 1 mm."""
    centres = np.stack(np.meshgrid(*[np.arange(64) - 31.5] * 3, indexing="ij"), axis=-1)
    matrix = np.eye(4)
    matrix[:3, 3] = -31.5
    free = np.linalg.norm(centres, axis=-1) < 30
    boxes = make_boxes(~free, matrix, outside=True)
    angles = np.linspace(0, 2.0, 25)
    bend = np.column_stack([25 - 25 * np.cos(angles), 0 * angles, 25 * np.sin(angles) - 29])
    tangents = np.column_stack([np.sin(angles), 0 * angles, np.cos(angles)])
    course = Course(25 * angles[None], bend[None], tangents[None])
    found = measure_clearances(course, RADIUS, boxes, PARAMETERS)
    fine = np.linspace(PARAMETERS.sheath_mm / 25, 2.0, 1000)
    points = np.column_stack([25 - 25 * np.cos(fine), 0 * fine, 25 * np.sin(fine) - 29])
    walls = centres[~free]
    near = walls[np.linalg.norm(walls, axis=1) < 31.5]
    gaps = [np.sqrt((np.maximum(abs(near - p) - 0.5, 0) ** 2).sum(axis=1).min()) for p in points]
    wanted = min(gaps) - RADIUS
    assert wanted - 2 * PARAMETERS.accuracy_mm < found.least_mm[0] <= wanted + 1e-3


def test_a_plate_thinner_than_the_samples_are_apart_is_found() -> None:
    plate = boxes_of(box_grid([((-40, -30, 40), (60, 30, 41))], cell=1.0))
    course = straight((0, 0, 0), [[0, 0, 1]], spacing=5.0)
    found = measure_clearances(course, RADIUS, plate, PARAMETERS)
    assert found.least_mm[0] <= -RADIUS + PARAMETERS.accuracy_mm
    assert 38 < found.arcs_mm[0] < 42


def test_what_is_touched_between_two_configurations_is_found() -> None:
    """A needle swings past a post that both of its configurations are clear of."""
    post = boxes_of(box_grid([around(np.array([0.0, 0, 50]), (-1, -1, -6), (1, 1, 6))], cell=1.0))
    ways = [[-0.1, 0, 1], [0.1, 0, 1]]
    apart = [
        measure_clearances(straight((0, 0, 0), [way]), RADIUS, post, PARAMETERS).least_mm[0]
        for way in ways
    ]
    assert min(apart) > 2
    swept = measure_clearances(straight((0, 0, 0), ways), RADIUS, post, PARAMETERS).least_mm[0]
    assert swept < 0


@settings(max_examples=20, deadline=None)
@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(0.001, 0.05))
def test_bounds_between_configurations_hold_for_all_between(x, y, turn) -> None:
    ways = np.array([[x, y, 1], [x + turn, y, 1]])
    found = measure_clearances(straight((30, 0, 0), ways), RADIUS, BOX, PARAMETERS)
    for share in np.linspace(0, 1, 7):
        way = (1 - share) * ways[0] + share * ways[1]
        fine = straight((30, 0, 0), [way], spacing=0.05)
        beyond = fine.arcs_mm[0] >= PARAMETERS.sheath_mm
        wanted = max(box_clearances(fine.points[0][beyond]).min(), -RADIUS)
        assert found.least_mm[0] <= wanted + 1e-3


def test_the_sheath_ends_where_the_needle_is_clear_or_is_as_long_as_allowed() -> None:
    course = straight((0, 0, 0), [[0, 0, 1]], spacing=0.1)
    found = measure_clearances(course, RADIUS, BOX, PARAMETERS)
    assert found.sheaths_mm[0] == pytest.approx(RADIUS + PARAMETERS.clear_mm, abs=0.11)
    along = straight((0, 0, 0.3), [[1, 0, 0]], spacing=0.1)
    found = measure_clearances(along, RADIUS, BOX, PARAMETERS)
    assert found.sheaths_mm[0] == pytest.approx(PARAMETERS.sheath_mm, abs=1e-9)
    assert found.least_mm[0] < 0


def test_a_needle_that_comes_back_to_the_wall_within_its_sheaths_reach_is_told() -> None:
    """It leaves the wall, and passes a bump 6 mm from its entry point."""
    bump = boxes_of(box_grid([((0, -30, 5), (60, 30, 7))], cell=1.0))
    course = straight((-0.7, 0, 0), [[0, 0, 1]], spacing=0.5)
    found = measure_clearances(course, RADIUS, bump, PARAMETERS)
    assert found.sheaths_mm[0] < 2 and 4 < found.arcs_mm[0] < 8
    assert found.least_mm[0] == pytest.approx(0.7 - RADIUS, abs=2 * PARAMETERS.accuracy_mm)
    away = straight((-1.5, 0, 0), [[0, 0, 1]], spacing=0.5)
    assert measure_clearances(away, RADIUS, bump, PARAMETERS).least_mm[0] > PARAMETERS.margin_mm


def test_many_configurations_are_measured_as_a_few() -> None:
    ways = np.array([[0.001 * turn, 0, 1] for turn in range(450)])
    whole = measure_clearances(straight((0, 0, 0), ways), RADIUS, BOX, PARAMETERS)
    part = measure_clearances(straight((0, 0, 0), ways[190:215]), RADIUS, BOX, PARAMETERS)
    assert len(whole.least_mm) == 449
    np.testing.assert_array_equal(whole.least_mm[190:214], part.least_mm)
