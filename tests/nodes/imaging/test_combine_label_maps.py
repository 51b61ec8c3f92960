"""Label maps on different grids become one: which grid, and what is in it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nodes.errors import BadInput
from nodes.geometry.grids import spacing_mm, voxel_volume_mm3
from nodes.imaging.combine_label_maps import combine_label_maps
from tests.nodes.imaging.handed_in import (
    block,
    combine_parameters,
    files,
    mask_file,
    steps,
)

SHAPE = (12, 11, 10)
LUNG = block(SHAPE, (2, 10), (2, 9), (2, 8))
AIRWAY = block(SHAPE, (4, 6), (4, 6), (1, 9))


def turned(step, start=(0.0, 0.0, 0.0)) -> np.ndarray:
    matrix = steps(*step, start=start)
    matrix[:3, :3] = Rotation.from_euler("xyz", (20, -10, 35), degrees=True).as_matrix() * step
    return matrix


def test_one_grid_for_all_is_kept_as_it_is():
    matrix = turned((0.5, 0.6, 0.7), (1, 2, 3))
    nearly = matrix + 1e-7
    nearly[3] = [0, 0, 0, 1]
    handed = files(mask_file("airway", AIRWAY, matrix), mask_file("lung", LUNG, nearly))
    combined = combine_label_maps(handed, combine_parameters())
    assert combined.voxels.shape == SHAPE and combined.names == ("airway", "lung")
    np.testing.assert_allclose(combined.patient_from_index, matrix, atol=1e-12)
    np.testing.assert_array_equal(combined.mask("airway"), AIRWAY)
    np.testing.assert_array_equal(combined.mask("lung"), LUNG & ~AIRWAY)
    assert not any("another grid" in notice for notice in combined.origin.notices)


def test_the_finest_file_gives_axes_spacing_and_its_own_voxels():
    fine = turned((0.5, 0.5, 0.5), (5, 5, 5))
    handed = files(mask_file("lung", LUNG, steps(2, 2, 2)), mask_file("airway", AIRWAY, fine))
    combined = combine_label_maps(handed, combine_parameters())
    np.testing.assert_allclose(combined.patient_from_index[:3, :3], fine[:3, :3])
    inside = np.argwhere(combined.mask("airway")) @ fine[:3, :3].T
    inside += combined.patient_from_index[:3, 3]
    expected = np.argwhere(AIRWAY) @ fine[:3, :3].T + fine[:3, 3]
    np.testing.assert_allclose(sorted(map(tuple, inside)), sorted(map(tuple, expected)), atol=1e-9)
    told = [notice for notice in combined.origin.notices if "another grid" in notice]
    assert len(told) == 1 and told[0].startswith("lung: brought from another grid")


def test_the_grid_holds_all_labels_and_the_margin_and_no_more():
    """Blocks from 0 to 8 mm and from 20 to 22 mm along x, along the others within. A corner of a
    block of larger voxels has the share (3/4)^3, which is less than half."""
    low = mask_file("low", np.ones((4, 4, 4), bool), steps(2, 2, 2, start=(1, 1, 1)))
    high = mask_file("high", np.ones((2, 2, 2), bool), steps(1, 1, 1, start=(20.5, 2.5, 2.5)))
    combined = combine_label_maps(files(low, high), combine_parameters(margin_mm=3.0))
    assert combined.voxels.shape == (28, 14, 14)
    np.testing.assert_allclose(combined.patient_from_index[:3, 3], -2.5)
    assert combined.mask("low").sum() == 8**3 - 8 and combined.mask("high").sum() == 8


def test_a_chosen_voxel_size_gives_cubes_on_the_axes_of_the_finest_file():
    fine = turned((0.5, 0.5, 1.0))
    handed = files(mask_file("lung", LUNG, fine))
    combined = combine_label_maps(handed, combine_parameters(voxel_size_mm=0.8))
    np.testing.assert_allclose(spacing_mm(combined.patient_from_index), 0.8)
    np.testing.assert_allclose(
        combined.patient_from_index[:3, :3] / 0.8, fine[:3, :3] / (0.5, 0.5, 1)
    )
    volume = combined.mask("lung").sum() * voxel_volume_mm3(combined.patient_from_index)
    assert volume == pytest.approx(LUNG.sum() * 0.25, rel=0.15)  # of cubes that fit by chance


def test_names_are_ours():
    parameters = combine_parameters(names={"bronchialTree": "airway"})
    combined = combine_label_maps(files(mask_file("bronchialTree", AIRWAY)), parameters)
    assert combined.names == ("airway",)


@settings(max_examples=20, deadline=None)
@given(st.permutations(range(4)))
def test_the_order_of_the_files_changes_nothing_but_the_numbers(order):
    maps = [
        mask_file("airway", AIRWAY, turned((0.5, 0.6, 0.7))),
        mask_file("lung", LUNG, steps(1, 1, 1)),
        mask_file("node", block(SHAPE, (5, 8), (5, 8), (5, 8)), steps(1, 1, 1, start=(0, 0, 1))),
        mask_file("same", block(SHAPE, (6, 9), (5, 8), (5, 8)), steps(0.7, 0.5, 0.6)),
    ]
    expected = combine_label_maps(files(*maps), combine_parameters())
    combined = combine_label_maps(files(*(maps[n] for n in order)), combine_parameters())
    np.testing.assert_array_equal(combined.patient_from_index, expected.patient_from_index)
    assert set(combined.origin.notices) == set(expected.origin.notices)
    for name in expected.names:
        np.testing.assert_array_equal(combined.mask(name), expected.mask(name))


def test_a_grid_of_too_many_voxels_is_refused_before_it_is_made():
    handed = files(
        mask_file("here", LUNG, steps(0.1, 0.1, 0.1)),
        mask_file("far", LUNG, steps(1, 1, 1, start=(9000, 0, 0))),
    )
    with pytest.raises(BadInput, match=r"million voxels\n.*at most 10 million"):
        combine_label_maps(handed, combine_parameters())


def test_no_labels_are_refused():
    with pytest.raises(BadInput, match="no labels"):
        combine_label_maps(files(), combine_parameters())
    with pytest.raises(BadInput, match="no labels"):
        combine_label_maps(files(mask_file("lung", LUNG)), combine_parameters(names={"lung": ""}))
