"""What voxels are to a needle, and that the cut-out box loses none that it can meet."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nodes.environment.build_occupancy_grid import build_occupancy_grid
from nodes.environment.needle_space import FORBIDDEN, FREE, OUTSIDE, WALL, cut_needle_space
from nodes.environment.parameters import (
    BuildOccupancyGridParameters,
    FindEntryCorridorsParameters,
)
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin

NAMES = ("body", "bone", "lung", "effusion")


def parameters(wall=("body",), thickest=6.0):
    return FindEntryCorridorsParameters(
        wall_labels=wall, bone_labels=("bone", "skull"),
        needle_radius_mm=1.0, margin_mm=1.0, thickest_wall_mm=thickest, tip_depth_mm=1.0,
        largest_tilt_deg=10.0, tilt_step_deg=10.0, skin_spacing_mm=2.0, step_mm=0.2,
        candidate_spacing_mm=5.0, enough_clearance_mm=5.0,
    )  # fmt: skip


def anatomy():
    """Two pools of fluid, 1000 and 64 mm^3, bone and lung in a body with air around it."""
    voxels = np.zeros((40, 30, 30), np.uint8)
    voxels[2:38, 2:28, 2:28] = 1
    voxels[5:15, 10:20, 10:20] = 4
    voxels[30:34, 10:14, 10:14] = 4
    voxels[18, 10:20, 10:20] = 2
    voxels[15, 10:20, 10:20] = 3
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", (20, 30, 40), degrees=True).as_matrix()
    matrix[:3, 3] = (100, -50, 20)
    return LabelMap(voxels, matrix, NAMES, Origin("test"))


def occupancy(label_map):
    chosen = BuildOccupancyGridParameters(
        free_labels=("effusion",), apart=(), voxel_size_mm=1.0, neighbourhood="faces",
        inside_patient_mm=(), smallest_part_ml=0.0, volume_tolerance=0.5,
    )  # fmt: skip
    return build_occupancy_grid(label_map, chosen)[0]


def test_each_voxel_is_what_its_label_and_part_say():
    label_map = anatomy()
    space = cut_needle_space(label_map, occupancy(label_map), "free", parameters(thickest=50.0))
    labels = label_map.voxels[space.box]
    assert space.kinds.shape == label_map.voxels.shape
    chosen = np.zeros(labels.shape, bool)
    chosen[5:15, 10:20, 10:20] = True
    expected = np.select([labels == 0, labels == 1, chosen], [OUTSIDE, WALL, FREE], FORBIDDEN)
    np.testing.assert_array_equal(space.kinds, expected)
    np.testing.assert_array_equal(space.bone, labels == 2)


def test_the_box_holds_all_within_the_widest_wall_and_knows_its_place():
    label_map = anatomy()
    space = cut_needle_space(label_map, occupancy(label_map), "free", parameters(thickest=6.0))
    reached = np.zeros(label_map.voxels.shape, bool)
    reached[space.box] = True
    places = np.argwhere(np.ones(reached.shape, bool))
    low, high = np.array([5, 10, 10]) - 0.5, np.array([14, 19, 19]) + 0.5
    gaps = np.maximum(np.maximum(low - places, places - high), 0)
    assert reached[tuple(places[np.linalg.norm(gaps, axis=1) < 6].T)].all()
    assert not reached.all()
    first = [side.start for side in space.box]
    expected = label_map.patient_from_index @ [*first, 1]
    np.testing.assert_allclose(space.patient_from_grid[:, 3], expected)
    assert space.distance.shape == space.kinds.shape
    assert space.distance[14 - first[0], 14, 14] == pytest.approx(0.5)


def test_unknown_labels_are_refused_and_missing_bone_labels_are_not():
    label_map = anatomy()
    grid = occupancy(label_map)
    assert cut_needle_space(label_map, grid, "free", parameters()).bone.any()
    with pytest.raises(BadInput, match="label pleura"):
        cut_needle_space(label_map, grid, "free", parameters(wall=("pleura",)))


def test_several_free_labels_are_known_by_their_place_and_a_strand_in_fluid_is_not_free():
    label_map = anatomy()
    voxels = label_map.voxels.copy()
    voxels[5:9, 10:20, 10:20] = 5  # a second kind of fluid
    voxels[5:15, 15, 15] = 3  # a strand of lung, as wide as a cell, through both
    names = (*NAMES, "blood")
    label_map = LabelMap(voxels, label_map.patient_from_index, names, label_map.origin)
    chosen = BuildOccupancyGridParameters(
        free_labels=("effusion", "blood"), apart=(), voxel_size_mm=1.0, neighbourhood="faces",
        inside_patient_mm=(), smallest_part_ml=0.0, volume_tolerance=0.5,
    )  # fmt: skip
    grid, _ = build_occupancy_grid(label_map, chosen)
    space = cut_needle_space(label_map, grid, "free", parameters(thickest=50.0))
    assert (space.kinds[voxels == 5] == FREE).all()
    assert (space.kinds[voxels == 3] == FORBIDDEN).all()


def test_each_part_is_free_to_its_own_needles_only():
    label_map = anatomy()
    grid = occupancy(label_map)
    small = cut_needle_space(label_map, grid, "part_2", parameters(thickest=50.0))
    expected = np.where(label_map.voxels == 4, FORBIDDEN, small.kinds)
    expected[30:34, 10:14, 10:14] = FREE
    np.testing.assert_array_equal(small.kinds, expected)
    assert small.part == "part_2" and small.cells.sum() == 4**3


def test_millimetres_along_the_grid_lead_to_the_cells():
    label_map = anatomy()
    space = cut_needle_space(label_map, occupancy(label_map), "free", parameters())
    first = np.array([side.start for side in space.box])
    at_cells = (np.argwhere(label_map.voxels == 4)[:1000] - first) * space.spacing
    cells = at_cells @ space.cell_from_grid[:3, :3].T + space.cell_from_grid[:3, 3]
    assert space.cells[tuple(np.rint(cells[:500]).astype(int).T)].all()
