"""The reader as a whole: what passes, what is refused, and what it says."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nodes.errors import BadInput
from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin
from nodes.imaging.artefacts import ImageFiles
from nodes.imaging.read_volume import read_volume
from tests.nodes.imaging.made_planes import PARAMETERS, settings_of, stack


@pytest.mark.parametrize("simulated", [True, False])
def test_simulated_is_inherited(simulated):
    files = ImageFiles(tuple(stack(range(3))), simulated=simulated)
    assert read_volume(files, PARAMETERS).origin.simulated == simulated


def test_skipped_files_are_told():
    volume = read_volume(ImageFiles(tuple(stack(range(3))), skipped=2), PARAMETERS)
    assert volume.origin.notices == ("files without an image plane were skipped: 2",)


def volume_file(matrix, shape=(6, 7, 8), value=-1000):
    voxels = np.full(shape, value, np.int16)
    return ImageFiles((), Volume(voxels, matrix, "intensity", Origin("volume file")))


def turned(*columns):
    """A matrix with these axes, turned somehow, and mirrored or not as they are."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.random(rng=np.random.default_rng(5)).as_matrix() @ np.transpose(
        columns
    )
    matrix[:3, 3] = [3, 4, 5]
    return matrix


@pytest.mark.parametrize("side", [1, -1])
def test_a_straight_volume_file_keeps_its_grid_to_the_last_digit(side):
    files = volume_file(turned([side * 0.7, 0, 0], [0, 0.7, 0], [0, 0, 3]))
    volume = read_volume(files, PARAMETERS)
    np.testing.assert_array_equal(volume.patient_from_index, files.volume.patient_from_index)
    np.testing.assert_array_equal(volume.voxels, files.volume.voxels)


@pytest.mark.parametrize("side", [1, -1])
def test_a_volume_file_whose_planes_lean_is_straightened_with_notice(side):
    files = volume_file(turned([side * 0.7, 0, 0], [0, 0.7, 0], [0, 1, 3]), value=-900)
    volume = read_volume(files, PARAMETERS)
    assert any(r"leaned by 18.4 deg" in notice for notice in volume.origin.notices)
    axes = volume.patient_from_index[:3, :3]
    np.testing.assert_allclose(np.linalg.norm(axes, axis=0), [0.7, 0.7, 3])
    np.testing.assert_allclose(axes.T @ axes, np.diag([0.49, 0.49, 9]), atol=1e-9)
    centre = (volume.voxels == -900).nonzero()
    place = (volume.patient_from_index @ [*np.mean(centre, axis=1), 1])[:3]
    before = (files.volume.patient_from_index @ [2.5, 3, 3.5, 1])[:3]
    np.testing.assert_allclose(place, before, atol=0.35)


def test_rows_and_columns_askew_are_refused():
    with pytest.raises(BadInput, match=r"meet at 78.7 deg"):
        read_volume(volume_file(turned([1, 0, 0], [0.2, 1, 0], [0, 0, 1])), PARAMETERS)


@pytest.mark.parametrize("axis", range(3))
def test_a_flat_volume_file_is_refused(axis):
    shape = [5, 6, 7]
    shape[axis] = 1
    with pytest.raises(BadInput, match="one plane only"):
        read_volume(volume_file(np.eye(4), tuple(shape)), PARAMETERS)


@pytest.mark.parametrize("scale", [1e-6, 1e4])
def test_sizes_that_no_scan_has_are_refused(scale):
    with pytest.raises(BadInput, match="unit must be mm"):
        read_volume(volume_file(np.diag([scale] * 3 + [1])), PARAMETERS)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("as_file", [True, False])
def test_voxels_that_are_no_numbers_are_refused(value, as_file):
    planes = stack(range(4))
    pixels = planes[1].pixels.copy()
    pixels[2, 3] = value
    planes[1] = replace(planes[1], pixels=pixels)
    voxels = np.stack([plane.pixels for plane in planes])
    volume = Volume(voxels, np.eye(4), "intensity", Origin("x"))
    files = ImageFiles((), volume) if as_file else ImageFiles(tuple(planes))
    with pytest.raises(BadInput, match="1 voxels are not a number"):
        read_volume(files, PARAMETERS)


def test_the_same_input_gives_the_same_bytes():
    files = ImageFiles(tuple(stack([0, 1, 2, 4], lean=(0.1, 0.2))))
    parameters = settings_of(uneven_spacing="resample")
    one, other = (read_volume(files, parameters) for _ in range(2))
    assert one.voxels.tobytes() == other.voxels.tobytes() and one.origin == other.origin


def test_inputs_stay_as_they_are():
    files = ImageFiles(tuple(stack(range(6), lean=(0.1, 0.2))))
    before = [plane.pixels.copy() for plane in files.slices]
    read_volume(files, PARAMETERS)
    for plane, pixels in zip(files.slices, before, strict=True):
        np.testing.assert_array_equal(plane.pixels, pixels)
