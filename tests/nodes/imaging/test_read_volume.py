"""Stacking planes: order comes from positions, and what is no even stack is refused."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nodes.errors import BadInput
from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin
from nodes.imaging.artefacts import ImageFiles, Slice
from nodes.imaging.parameters import ReadVolumeParameters
from nodes.imaging.read_volume import read_volume

PARAMETERS = ReadVolumeParameters(
    modality="CT",
    position_tolerance_mm=0.1,
    orientation_tolerance_deg=0.1,
    tilt_tolerance_deg=0.5,
    smallest_spacing_mm=0.01,
    largest_extent_mm=3000,
    lowest_hu=-1024,
)
WATER = lambda points: points @ [1.0, 2.0, 4.0]  # noqa: E731 - a field that tells every place apart


def stack(heights, seed=0, lean=(0.0, 0.0), series=1, modality="CT", shape=(4, 6)):
    """Planes at these heights along an oblique normal, whose values are a linear field."""
    axes = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    slices = []
    for height in heights:
        matrix = np.eye(4)
        matrix[:3, :3] = axes * [0.5, 0.8, 1.0]
        matrix[:3, 3] = axes @ [lean[0] * height, lean[1] * height, height]
        rows, columns = np.indices(shape)
        pixel = np.stack([columns, rows, 0 * rows, 1 + 0 * rows], axis=-1)
        values = WATER((pixel @ matrix.T)[..., :3]).astype(np.float32)
        unit = "HU" if modality == "CT" else "intensity"
        slices.append(Slice(values, matrix, series, modality, unit))
    return slices


@settings(max_examples=25, deadline=None)
@given(st.permutations(range(6)), st.integers(0, 99), st.floats(0.3, 9))
def test_every_voxel_lies_where_its_value_says_for_any_order_of_files(order, seed, step):
    slices = stack(step * np.arange(6), seed)
    volume = read_volume(ImageFiles(tuple(slices[index] for index in order)), PARAMETERS)
    index = np.indices(volume.voxels.shape).reshape(3, -1)
    places = (volume.patient_from_index @ np.vstack([index, np.ones(index.shape[1])]))[:3].T
    np.testing.assert_allclose(volume.voxels.reshape(-1), WATER(places), rtol=1e-4, atol=1e-3)
    assert np.linalg.det(volume.patient_from_index[:3, :3]) > 0
    assert volume.voxels.shape == (6, 4, 6)


@pytest.mark.parametrize(
    ("heights", "words"),
    [
        ([0, 1, 2, 4, 5], "distances between planes from 1.00 to 2.00 mm"),
        ([0, 1, 2, 2, 3], "distances between planes from 0.00 to 1.00 mm"),
        ([0, 1, 2.3, 3, 4], "distances between planes"),
        ([0], "one plane only"),
    ],
)
def test_missing_doubled_shifted_and_single_planes_are_refused(heights, words):
    with pytest.raises(BadInput, match=words):
        read_volume(ImageFiles(tuple(stack(heights))), PARAMETERS)


def test_rounded_positions_are_accepted():
    heights = np.round(np.arange(200) * 0.6667, 1)
    assert read_volume(ImageFiles(tuple(stack(heights))), PARAMETERS).voxels.shape[2] == 200


@pytest.mark.parametrize("lean", [(0, 0.25), (-0.02, 0)])
def test_gantry_tilt_is_refused_with_its_angle(lean):
    degrees = f"{np.rad2deg(np.arctan(np.hypot(*lean))):.1f} deg"
    with pytest.raises(BadInput, match=f"leans by {degrees}"):
        read_volume(ImageFiles(tuple(stack(range(8), lean=lean))), PARAMETERS)


def test_a_plane_shifted_sideways_is_refused():
    slices = stack(range(8))
    moved = slices[3].patient_from_pixel.copy()
    moved[:3, 3] += moved[:3, 0]
    slices[3] = replace(slices[3], patient_from_pixel=moved)
    with pytest.raises(BadInput, match=r"sideways by up to 0.50 mm"):
        read_volume(ImageFiles(tuple(slices)), PARAMETERS)


def test_mixed_orientations_are_refused():
    slices = stack(range(4)) + stack(range(4), seed=1)
    with pytest.raises(BadInput, match="turned by up to"):
        read_volume(ImageFiles(tuple(slices)), PARAMETERS)


def test_planes_of_other_size_or_spacing_are_refused():
    slices = stack(range(4)) + stack([4], shape=(4, 5))
    with pytest.raises(BadInput, match="several sizes"):
        read_volume(ImageFiles(tuple(slices)), PARAMETERS)
    wide = slices[3].patient_from_pixel @ np.diag([1.1, 1, 1, 1])
    slices[3:] = [replace(slices[3], patient_from_pixel=wide)]
    with pytest.raises(BadInput, match="several pixel spacings"):
        read_volume(ImageFiles(tuple(slices)), PARAMETERS)


def test_the_largest_series_of_the_modality_is_chosen_and_said():
    slices = (
        stack(range(3), series=1)
        + stack(range(5), series=2)
        + stack(range(9), series=3, modality="MR")
    )
    volume = read_volume(ImageFiles(tuple(slices), skipped=2), PARAMETERS)
    assert volume.voxels.shape[2] == 5 and volume.unit == "HU"
    assert volume.origin.notices == (
        "series 2 of 3 was chosen, the largest (5 planes)",
        "2 files hold no image plane and were skipped",
    )
    anything = read_volume(
        ImageFiles(tuple(slices)), PARAMETERS.model_copy(update={"modality": "any"})
    )
    assert anything.voxels.shape[2] == 9 and anything.unit == "intensity"


def test_a_missing_modality_is_refused_with_what_there_is():
    with pytest.raises(BadInput, match="modalities found: MR"):
        read_volume(ImageFiles(tuple(stack(range(3), modality="MR"))), PARAMETERS)


@pytest.mark.parametrize("simulated", [True, False])
def test_simulated_is_inherited(simulated):
    files = ImageFiles(tuple(stack(range(3))), simulated=simulated)
    assert read_volume(files, PARAMETERS).origin.simulated == simulated


def test_values_below_air_are_clipped_and_counted():
    slices = stack(range(3))
    pixels = np.full((4, 6), 7, np.int16)
    pixels[0, :3] = [-3024, -1025, -1024]
    slices = [replace(plane, pixels=pixels) for plane in slices]
    volume = read_volume(ImageFiles(tuple(slices)), PARAMETERS)
    assert volume.voxels.min() == -1024 and volume.voxels.dtype == np.int16
    assert volume.origin.notices[0].startswith("6 voxels below -1024 HU")
    np.testing.assert_array_equal(volume.voxels[:, :, 0].T, np.maximum(pixels, -1024))


def volume_file(lowest: int) -> ImageFiles:
    voxels = np.full((2, 3, 4), lowest, np.int16)
    return ImageFiles((), Volume(voxels, np.eye(4), "intensity", Origin("volume file")))


def test_a_volume_file_passes_and_is_hu_only_where_it_can_be():
    assert read_volume(volume_file(-1000), PARAMETERS).unit == "HU"
    eight_bit = read_volume(volume_file(0), PARAMETERS)
    assert eight_bit.unit == "intensity"
    assert any("not HU" in notice for notice in eight_bit.origin.notices)
    mr = read_volume(volume_file(-1000), PARAMETERS.model_copy(update={"modality": "MR"}))
    assert mr.unit == "intensity" and mr.origin.notices == ()


TRAPS = {
    "failing/gantrytilting/001": "leans by 14.0 deg",
    "failing/notavolume/001": "distances between planes",
    "failing/sliceincrement/001": "distances between planes from 5.00 to 10.00",
    "failing/sliceincrement/002": "distances between planes from 0.75 to 1.50",
    "failing/sliceorientation/001": "turned by up to",
    "ge/anatomical/001_single_slice": "one plane only",
    "generic/rgb/001": "none with an image plane",
    "philips_enhanced/anatomical/001": "none with an image plane",
}


@pytest.mark.parametrize(("trap", "words"), TRAPS.items())
def test_traps_of_real_scanners_are_refused(test_data, trap, words):
    from catalog.formats.image_files import ImageFilesFormat

    root = test_data / "dicom_traps" / trap
    files = {path.name: path.read_bytes() for path in root.iterdir()}
    with pytest.raises(BadInput, match=words):
        read_volume(
            ImageFilesFormat.decode(files), PARAMETERS.model_copy(update={"modality": "any"})
        )


def test_a_real_tilted_head_is_refused_and_the_straight_one_read(test_data):
    from catalog.formats.image_files import ImageFilesFormat

    root = test_data / "head_ct_phantom"
    straight, tilted = (
        ImageFilesFormat.decode({path.name: path.read_bytes() for path in (root / name).iterdir()})
        for name in ("straight_S2020", "tilted_S3010")
    )
    volume = read_volume(straight, PARAMETERS)
    heights = sorted(plane.patient_from_pixel[2, 3] for plane in straight.slices)
    assert volume.voxels.shape[2] == len(heights)
    steps = {round(high - low, 3) for low, high in pairwise(heights)}
    assert steps == {round(float(volume.patient_from_index[2, 2]), 3)}
    with pytest.raises(BadInput, match=r"leans by 16.5 deg"):
        read_volume(tilted, PARAMETERS)


@pytest.mark.parametrize("scale", [1e-6, 1e4])
def test_sizes_that_no_scan_has_are_refused(scale):
    volume = Volume(
        np.full((8, 9, 10), -5, np.int16), np.diag([scale] * 3 + [1]), "HU", Origin("x")
    )
    with pytest.raises(BadInput, match="unit must be mm"):
        read_volume(ImageFiles((), volume), PARAMETERS)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_voxels_that_are_no_numbers_are_refused(value):
    voxels = np.full((4, 5, 6), -5, np.float32)
    voxels[1, 2, 3] = value
    volume = Volume(voxels, np.eye(4), "HU", Origin("x"))
    with pytest.raises(BadInput, match="1 voxels are not a number"):
        read_volume(ImageFiles((), volume), PARAMETERS)
