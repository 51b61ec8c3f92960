"""The signed distance field of a free space: boxes by formula, and what holds of every grid."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nodes.environment.measure_distance import measure_distance
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin

CELL = 1.5


def grid(labels, names=("free", "boundary")):
    matrix = np.diag([CELL, CELL, CELL, 1.0])
    return LabelMap(np.asarray(labels, np.uint8), matrix, names, Origin("x", True, ("n",)))


def test_a_box_of_free_cells_has_the_distances_of_its_formula():
    labels = np.zeros((14, 16, 18))
    labels[3:11, 4:12, 5:13] = 1
    low, high = np.array([2.5, 3.5, 4.5]) * CELL, np.array([10.5, 11.5, 12.5]) * CELL
    centres = np.stack(np.indices(labels.shape), axis=-1) * CELL
    outside = np.linalg.norm(np.maximum(np.maximum(low - centres, centres - high), 0), axis=-1)
    inside = np.minimum(centres - low, high - centres).min(axis=-1)
    expected = np.where(labels == 1, inside, -outside)
    distance = measure_distance(grid(labels))
    np.testing.assert_allclose(distance.voxels, expected, rtol=1e-6)
    assert distance.unit == "mm" and distance.voxels.dtype == np.float32
    assert distance.origin == Origin("signed distance to the walls of x", True, ("n",))


def test_other_parts_and_all_beyond_the_grid_are_obstacle():
    labels = np.zeros((9, 5, 5))
    labels[:4], labels[5:] = 1, 3
    distance = measure_distance(grid(labels, ("free", "boundary", "part_2"))).voxels
    assert distance[0, 2, 2] == np.float32(0.5 * CELL)
    assert distance[2, 2, 2] == np.float32(1.5 * CELL)
    assert (distance[5:] < 0).all()


@settings(max_examples=40, deadline=None)
@given(arrays(np.uint8, st.tuples(*[st.integers(1, 6)] * 3), elements=st.integers(0, 2)))
def test_signs_tell_free_from_obstacle_and_no_step_changes_more_than_its_length(labels):
    distance = measure_distance(grid(labels)).voxels
    np.testing.assert_array_equal(distance > 0, labels == 1)
    if (labels == 1).any():
        for axis in range(3):
            # across the surface each centre is half a cell from it, on either side
            assert (abs(np.diff(distance, axis=axis)) <= CELL * (1 + 1e-6)).all()
