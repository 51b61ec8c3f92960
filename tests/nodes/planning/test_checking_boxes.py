"""Distances to boxes against all boxes one by one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from nodes.errors import BadInput
from nodes.planning.checking_boxes import bound_distances, make_boxes, measure_distances

MATRIX = np.eye(4)
MATRIX[:3, :3] = Rotation.from_rotvec([0.3, -0.7, 0.4]).as_matrix() * [1.0, 1.5, 2.0]
MATRIX[:3, 3] = [5, -3, 40]
PLACES = hnp.arrays(float, (6, 3), elements=st.floats(-2, 8))


def to_patient(index: np.ndarray) -> np.ndarray:
    return index @ MATRIX[:3, :3].T + MATRIX[:3, 3]


def by_force(occupied: np.ndarray, index: np.ndarray, outside: bool) -> np.ndarray:
    """Over all boxes of a grid that is continued by some cells; 0 within one."""
    ring = 12
    cells = np.argwhere(np.pad(occupied, ring, constant_values=outside)) - ring
    gaps = np.maximum(abs(index[:, None] - cells) - 0.5, 0.0) * [1.0, 1.5, 2.0]
    return np.sqrt((gaps**2).sum(axis=2)).min(axis=1, initial=np.inf)


@settings(max_examples=60, deadline=None)
@given(hnp.arrays(bool, (4, 5, 3)), PLACES, st.booleans())
def test_distances_are_those_to_the_nearest_of_all_boxes(occupied, index, outside) -> None:
    boxes = make_boxes(occupied, MATRIX, outside)
    wanted = by_force(occupied, index, outside)
    found = measure_distances(to_patient(index), boxes)
    # Points on a face belong to either cell.
    within = abs(abs(index - np.rint(index)) - 0.5).min(axis=1) < 1e-9
    assert found[~within] == pytest.approx(wanted[~within], abs=1e-9)
    low, high = bound_distances(to_patient(index), boxes)
    assert (low <= found + 1e-9).all() and (found <= high + 1e-9)[~within].all()


def test_far_from_a_wall_the_distance_is_never_told_too_large() -> None:
    occupied = np.zeros((60, 60, 3), bool)
    occupied[:, :, 0] = True
    boxes = make_boxes(occupied, np.eye(4), outside=False)
    points = np.column_stack([np.full(50, 30.3), np.full(50, 29.9), np.linspace(1, 40, 50)])
    found, wanted = measure_distances(points, boxes), points[:, 2] - 0.5
    assert (found <= wanted + 1e-12).all()
    assert found[wanted < 8] == pytest.approx(wanted[wanted < 8])
    assert (wanted - found).max() < np.sqrt(3) / 2


def test_without_boxes_all_is_far() -> None:
    boxes = make_boxes(np.zeros((3, 3, 3), bool), np.eye(4), outside=False)
    assert np.isinf(measure_distances(np.ones((2, 3)), boxes)).all()
    assert np.isinf(bound_distances(np.ones((2, 3)), boxes)).all()


def test_an_oblique_grid_is_refused() -> None:
    sheared = np.eye(4)
    sheared[0, 1] = 0.1
    with pytest.raises(BadInput, match="orthogonal"):
        make_boxes(np.ones((2, 2, 2), bool), sheared, outside=True)
