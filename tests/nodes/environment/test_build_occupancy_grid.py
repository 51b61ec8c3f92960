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
STEPS = [step for step in product((-1, 0, 1), repeat=3) if any(step)]
NEIGHBOURS = {"faces": 6, "edges": 18, "corners": 26}


def parameters(size, labels=("lungs",), **changed):
    values = {
        "free_labels": labels,
        "apart": (),
        "voxel_size_mm": size,
        "neighbourhood": "faces",
        "inside_patient_mm": (),
        "smallest_part_ml": 0.0,
        "volume_tolerance": 0.02,
    }
    return BuildOccupancyGridParameters(**{**values, **changed})


def lungs(mask, spacing=(1.0, 1.0, 1.0)):
    voxels = np.where(mask, 2, 1).astype(np.uint8)
    return LabelMap(voxels, np.diag([*spacing, 1.0]), ("body", "lungs"), ORIGIN)


def ball(shape=(50, 50, 25), spacing=(1.0, 1.0, 2.0), radius=20.0):
    middle = (np.array(shape) - 1) / 2
    index = np.stack(np.indices(shape), axis=-1) - middle
    return (((index * spacing) ** 2).sum(axis=-1) < radius**2), spacing


@settings(max_examples=25, deadline=None)
@given(
    arrays(bool, st.tuples(*[st.integers(1, 5)] * 3)),
    st.floats(0.7, 1.3),
    st.sampled_from(list(NEIGHBOURS)),
)
def test_boundary_is_every_obstacle_cell_next_to_a_free_one(mask, size, kind):
    assume(mask.any())
    try:
        grid, _ = build_occupancy_grid(lungs(mask), parameters(size, neighbourhood=kind))
    except BadInput:
        assume(False)
    free, obstacle = grid.mask("free"), np.isin(grid.voxels, (0, 2))
    steps = sorted(STEPS, key=lambda step: sum(map(abs, step)))[: NEIGHBOURS[kind]]
    for place in np.ndindex(free.shape):
        around = [tuple(p + s for p, s in zip(place, step, strict=True)) for step in steps]
        touches = any(
            all(0 <= a < n for a, n in zip(other, free.shape, strict=True)) and free[other]
            for other in around
        )
        assert grid.mask("boundary")[place] == (touches and obstacle[place])
    assert any(f"({NEIGHBOURS[kind]} neighbours)" in notice for notice in grid.origin.notices)


@settings(max_examples=30, deadline=None)
@given(arrays(bool, st.tuples(*[st.integers(1, 5)] * 3)))
def test_free_never_reaches_the_edge_of_the_grid(mask):
    assume(mask.any())
    free = build_occupancy_grid(lungs(mask), parameters(1.0))[0].mask("free")
    assert free[1:-1, 1:-1, 1:-1].sum() == free.sum() > 0


@pytest.mark.parametrize("size", [0.8, 1.5, 2.5])
def test_a_ball_keeps_volume_and_place_at_any_cell_size(size):
    mask, spacing = ball()
    grid, _ = build_occupancy_grid(lungs(mask, spacing), parameters(size))
    free = grid.mask("free")
    assert free.sum() * size**3 == pytest.approx(4 / 3 * np.pi * 20**3, rel=0.03)
    centre = grid.patient_from_index @ [*np.argwhere(free).mean(axis=0), 1]
    np.testing.assert_allclose(centre[:3], [24.5, 24.5, 24.0], atol=0.3)
    np.testing.assert_allclose(abs(np.linalg.det(grid.patient_from_index)), size**3)


def three_parts():
    """Boxes of 200 and 75 voxels of 0.001 ml, and one voxel at an edge of the first."""
    mask = np.zeros((20, 9, 9), bool)
    mask[2:10, 2:7, 2:7] = True
    mask[10, 7, 7] = True  # over an edge only
    mask[14:17, 2:7, 2:7] = True
    return lungs(mask)


def test_parts_are_named_by_size_and_small_ones_are_obstacle_and_said():
    grid, table = build_occupancy_grid(three_parts(), parameters(1.0, smallest_part_ml=0.01))
    assert grid.names == ("free", "boundary", "part_2")
    assert (grid.mask("free").sum(), grid.mask("part_2").sum()) == (200, 75)
    assert any("1 small parts" in n and "(0.001 ml)" in n for n in grid.origin.notices)
    assert any("fall into 2 parts" in n for n in grid.origin.notices)
    assert list(table.name) == ["free", "part_2"] and list(table.chosen) == [True, False]
    assert list(table.cells) == [200, 75]
    assert list(table.volume_ml) == pytest.approx([0.2, 0.075])
    assert list(table.boundary_cells) == [2 * (8 * 5 * 2 + 25), 2 * (3 * 5 * 2 + 25)]
    assert list(table.centre_x_mm) == pytest.approx([5.5, 15.0])
    assert list(table.centre_y_mm) == list(table.centre_z_mm) == pytest.approx([4.0, 4.0])


def test_a_point_chooses_its_part_and_one_beside_all_parts_is_refused():
    inside = parameters(1.0, inside_patient_mm=((15.0, 4.0, 4.0),))
    grid, table = build_occupancy_grid(three_parts(), inside)
    assert grid.mask("free").sum() == 75
    assert list(table.cells) == [75, 200, 1]
    for point in ((12.0, 4.0, 4.0), (400.0, 0.0, 0.0), (-400.0, 0.0, 0.0)):
        with pytest.raises(BadInput, match="inside_patient_mm"):
            build_occupancy_grid(three_parts(), parameters(1.0, inside_patient_mm=(point,)))


def test_several_labels_are_free_together():
    voxels = np.ones((12, 8, 8), np.uint8)
    voxels[2:6, 2:6, 2:6], voxels[6:10, 2:6, 2:6] = 2, 3
    label_map = LabelMap(voxels, np.eye(4), ("body", "left_lung", "effusion"), ORIGIN)
    grid, _ = build_occupancy_grid(label_map, parameters(1.0, ("left_lung", "effusion")))
    assert grid.mask("free").sum() == 8 * 16
    assert grid.origin.source == "left_lung and effusion of test"


def test_more_parts_than_labels_can_name_become_obstacle():
    mask = np.zeros((25, 25, 25), bool)
    mask[1:-1:2, 1:-1:2, 1:-1:2] = True
    grid, table = build_occupancy_grid(lungs(mask), parameters(1.0))
    assert len(table) == 251 and grid.voxels.max() == 252
    assert any(f"{12**3 - 251} small parts" in notice for notice in grid.origin.notices)


def test_cells_that_hold_another_volume_than_the_label_say_so():
    mask = np.zeros((9, 9, 9), bool)
    mask[2:7, 2:7, 3:6] = True
    assert not any(
        "hold" in n for n in build_occupancy_grid(lungs(mask), parameters(1.0))[0].origin.notices
    )
    notices = build_occupancy_grid(lungs(mask), parameters(2.0))[0].origin.notices
    assert any("cells of 2 mm hold" in notice for notice in notices)


@pytest.mark.parametrize("size", [1.0, 1.5])
def test_the_boundary_area_of_a_ball_is_that_of_its_formula(size):
    mask, spacing = ball()
    _, table = build_occupancy_grid(lungs(mask, spacing), parameters(size))
    assert table.boundary_area_cm2[0] == pytest.approx(4 * np.pi * 20**2 / 100, rel=0.03)


def test_an_open_end_at_the_images_edge_is_closed_and_said():
    mask = np.zeros((6, 6, 6), bool)
    mask[2:4, 2:4, :] = True
    grid, _ = build_occupancy_grid(lungs(mask), parameters(1.0))
    assert any("edge of the image" in notice for notice in grid.origin.notices)
    assert grid.mask("boundary").sum() == 4 * 2 * 6 + 2 * 4


def test_source_and_simulation_are_passed_on():
    mask, spacing = ball()
    grid, _ = build_occupancy_grid(lungs(mask, spacing), parameters(2.0))
    assert (grid.origin.source, grid.origin.simulated) == ("lungs of test", True)


def test_unknown_empty_and_tiny_labels_are_refused():
    mask = np.zeros((9, 9, 9), bool)
    with pytest.raises(BadInput, match="body, lungs"):
        build_occupancy_grid(lungs(mask), parameters(1.0, ("pleura",)))
    with pytest.raises(BadInput, match="no free cell"):
        build_occupancy_grid(lungs(mask), parameters(1.0))
    mask[4, 4, 4] = True
    with pytest.raises(BadInput, match="no free cell"):
        build_occupancy_grid(lungs(mask), parameters(5.0))
