"""Free cells and their boundary, against brute force and closed forms."""

from itertools import product

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nodes.environment.build_occupancy_grid import build_occupancy_grid
from nodes.environment.parameters import BuildOccupancyGridParameters
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin

ORIGIN = Origin("test", simulated=True)
STEPS = [step for step in product((-1, 0, 1), repeat=3) if sum(map(abs, step)) == 1]


def parameters(size, label="lungs"):
    return BuildOccupancyGridParameters(free_label=label, voxel_size_mm=size)


def lungs(mask, spacing=(1.0, 1.0, 1.0)):
    voxels = np.where(mask, 2, 1).astype(np.uint8)
    return LabelMap(voxels, np.diag([*spacing, 1.0]), ("body", "lungs"), ORIGIN)


def ball(shape=(50, 50, 25), spacing=(1.0, 1.0, 2.0), radius=20.0):
    middle = (np.array(shape) - 1) / 2
    index = np.stack(np.indices(shape), axis=-1) - middle
    return (((index * spacing) ** 2).sum(axis=-1) < radius**2), spacing


@settings(max_examples=40, deadline=None)
@given(arrays(bool, st.tuples(*[st.integers(1, 5)] * 3)), st.floats(0.7, 1.3))
def test_boundary_is_every_obstacle_cell_with_a_free_face_neighbour(mask, size):
    assume(mask.any())
    try:
        grid = build_occupancy_grid(lungs(mask), parameters(size))
    except BadInput:
        assume(False)
    free = grid.mask("free")
    for place in np.ndindex(free.shape):
        around = [tuple(p + s for p, s in zip(place, step, strict=True)) for step in STEPS]
        touches = any(
            all(0 <= a < n for a, n in zip(other, free.shape, strict=True)) and free[other]
            for other in around
        )
        assert grid.mask("boundary")[place] == (touches and not free[place])


@settings(max_examples=30, deadline=None)
@given(arrays(bool, st.tuples(*[st.integers(1, 5)] * 3)))
def test_free_never_reaches_the_edge_of_the_grid(mask):
    assume(mask.any())
    free = build_occupancy_grid(lungs(mask), parameters(1.0)).mask("free")
    assert free[1:-1, 1:-1, 1:-1].sum() == free.sum() > 0


@pytest.mark.parametrize("size", [0.8, 1.5, 2.5])
def test_a_ball_keeps_volume_and_place_at_any_cell_size(size):
    mask, spacing = ball()
    grid = build_occupancy_grid(lungs(mask, spacing), parameters(size))
    free = grid.mask("free")
    assert free.sum() * size**3 == pytest.approx(4 / 3 * np.pi * 20**3, rel=0.03)
    centre = grid.patient_from_index @ [*np.argwhere(free).mean(axis=0), 1]
    np.testing.assert_allclose(centre[:3], [24.5, 24.5, 24.0], atol=0.3)
    np.testing.assert_allclose(abs(np.linalg.det(grid.patient_from_index)), size**3)


def test_only_the_largest_part_is_free_and_the_rest_is_said():
    mask = np.zeros((20, 9, 9), bool)
    mask[2:10, 2:7, 2:7] = True
    mask[10, 7, 7] = True  # over an edge only
    mask[14:17, 2:7, 2:7] = True
    grid = build_occupancy_grid(lungs(mask), parameters(1.0))
    assert grid.mask("free").sum() == 8 * 5 * 5
    assert any("0.076 ml" in notice for notice in grid.origin.notices)


def test_an_open_end_at_the_images_edge_is_closed_and_said():
    mask = np.zeros((6, 6, 6), bool)
    mask[2:4, 2:4, :] = True
    grid = build_occupancy_grid(lungs(mask), parameters(1.0))
    assert any("edge of the image" in notice for notice in grid.origin.notices)
    assert grid.mask("boundary").sum() == 4 * 2 * 6 + 2 * 4


def test_source_and_simulation_are_passed_on():
    mask, spacing = ball()
    grid = build_occupancy_grid(lungs(mask, spacing), parameters(2.0))
    assert grid.origin == Origin("lungs of test", simulated=True)


def test_unknown_empty_and_tiny_labels_are_refused():
    mask = np.zeros((9, 9, 9), bool)
    with pytest.raises(BadInput, match="body, lungs"):
        build_occupancy_grid(lungs(mask), parameters(1.0, "pleura"))
    with pytest.raises(BadInput, match="no free cell"):
        build_occupancy_grid(lungs(mask), parameters(1.0))
    mask[4, 4, 4] = True
    with pytest.raises(BadInput, match="no free cell"):
        build_occupancy_grid(lungs(mask), parameters(5.0))
