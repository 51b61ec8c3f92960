"""The reader on files of real scanners: each is read right, or refused for the right reason."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import SimpleITK as sitk

from benchmarks.tilted_heads import bone_ratio, lay_together
from catalog.formats.image_files import ImageFilesFormat
from catalog.signatures import read_files
from nodes.errors import BadInput
from nodes.geometry.grids import Volume, spacing_mm
from nodes.imaging.read_volume import read_volume
from tests.nodes.imaging.made_planes import settings_of

# Every folder with files below dicom_traps: what breaks a rule, with the rule ...
REFUSED = {
    "failing/notavolume/001": ("4 planes at one place", "lie apart"),
    "failing/slicecount/001": ("2 planes only", "3 planes or more"),
    "failing/sliceincrement/001": ("10.00 mm between planes 3 and 4 of 4", "none is missing"),
    "failing/sliceincrement/002": ("1.50 mm between planes 3 and 4 of 4", "none is missing"),
    "failing/sliceorientation/001": ("2 series and no clear choice", "clearly the largest"),
    "ge/anatomical/001_single_slice": ("one plane only", "3 planes or more"),
    "generic/rgb/001": ("4 files, none with an image plane", "images are grey"),
}
# ... what is mended, with the notice ...
MENDED = {"failing/gantrytilting/001": "leaned by 14.0 deg"}
# ... and what is read as it is, with shape and unit; the truth lies beside it.
READ = {
    "ge/anatomical/001": (256, 256, 4),
    "ge/anatomical/001_implicit": (256, 256, 4),
    "generic/anatomical/001": (256, 256, 4),
    "generic/anatomical/001_implicit": (256, 256, 4),
    "generic/anatomical/002_non_isotropic": (64, 28, 4),
    "generic/compressed/001": (256, 256, 4),
    "generic/compressed_j2k/001": (256, 256, 4),
    "generic/compressed_jpeg/001": (256, 256, 4),
    "generic/compressed_jpegls/001": (256, 256, 4),
    "generic/compressed_rle/001": (256, 256, 4),
    "hyperfine/anatomical/001": (112, 138, 8),
    "philips_enhanced/anatomical/001": (256, 256, 8),
    "philips_enhanced/anatomical/001_implicit": (256, 256, 8),
    "siemens/anatomical/001": (256, 256, 4),
    "siemens/anatomical/001_implicit": (256, 256, 4),
}


@cache
def read(path: Path, modality: str = "any", **changed) -> Volume:
    files = ImageFilesFormat.decode(read_files(path))
    return read_volume(files, settings_of(modality=modality, **changed))


def test_every_trap_has_an_expected_outcome(test_data):
    root = test_data / "dicom_traps"
    files = (path for path in root.rglob("*") if path.is_file() and path.suffix != ".gz")
    folders = {str(path.parent.relative_to(root)) for path in files} - {"."}
    assert folders == {*REFUSED, *MENDED, *READ}


@pytest.mark.parametrize("trap", REFUSED)
def test_a_trap_is_refused_with_value_and_rule(test_data, trap):
    with pytest.raises(BadInput) as caught:
        read(test_data / "dicom_traps" / trap)
    value, rule = REFUSED[trap]
    assert value in caught.value.value and rule in caught.value.rule and caught.value.cure


@pytest.mark.parametrize("trap", READ)
def test_a_trap_is_read_as_the_published_truth(test_data, trap):
    path = test_data / "dicom_traps" / trap
    volume = read(path)
    assert volume.voxels.shape == READ[trap] and volume.unit == "intensity"
    assert volume.origin.notices == ()
    truth = sitk.ReadImage(f"{path}_ground_truth.nii.gz")
    values = sitk.GetArrayFromImage(truth).transpose(2, 1, 0)
    index = np.indices(volume.voxels.shape).reshape(3, -1)
    places = volume.patient_from_index @ np.vstack([index, np.ones(index.shape[1])])
    axes = np.reshape(truth.GetDirection(), (3, 3)) * truth.GetSpacing()
    there = np.linalg.solve(axes, places[:3] - np.reshape(truth.GetOrigin(), (3, 1)))
    assert abs(there - np.rint(there)).max() < 2e-3  # one grid, but for rounding in the headers
    expected = values[tuple(np.rint(there).astype(int))]
    np.testing.assert_allclose(volume.voxels.reshape(-1), expected, rtol=1e-6, atol=1e-4)
    assert volume.voxels.size == values.size


@pytest.mark.parametrize("trap", MENDED)
def test_a_leaning_trap_is_straightened_and_keeps_its_values(test_data, trap):
    path = test_data / "dicom_traps" / trap
    volume = read(path)
    assert any(MENDED[trap] in notice for notice in volume.origin.notices)
    axes = volume.patient_from_index[:3, :3]
    np.testing.assert_allclose(axes.T @ axes, np.diag(spacing_mm(volume.patient_from_index) ** 2),
                               atol=1e-6)  # fmt: skip
    planes = ImageFilesFormat.decode(read_files(path)).slices
    rows = np.arange(volume.voxels.shape[1])
    for k, plane in enumerate(sorted(planes, key=lambda plane: plane.patient_from_pixel[2, 3])):
        index = np.stack([0 * rows + 100, rows, 0 * rows + k, 0 * rows + 1])
        row = np.linalg.solve(plane.patient_from_pixel, volume.patient_from_index @ index)[1]
        scanned = (row >= -1e-4) & (row <= 511 + 1e-4)
        expected = np.interp(row, np.arange(512), plane.pixels[:, 100])
        expected[~scanned] = -1024
        np.testing.assert_allclose(volume.voxels[100, :, k], expected, atol=0.6)
        assert scanned.sum() > 500


def test_an_uneven_trap_can_be_filled_knowingly(test_data):
    path = test_data / "dicom_traps" / "failing" / "sliceincrement" / "001"
    volume = read(path, uneven_spacing="resample")
    assert volume.voxels.shape == (512, 512, 5)
    assert any("5.00 to 10.00 mm apart" in notice for notice in volume.origin.notices)
    missing = (volume.voxels[:, :, 2].astype(float) + volume.voxels[:, :, 4]) / 2
    np.testing.assert_allclose(volume.voxels[:, :, 3], missing, atol=1)


IMAGES = {
    "head_ct_phantom/straight_S2020": (
        ("CT", (512, 512, 140), (0.451, 0.451, 1.0), "HU"),
        ("files without an image plane were skipped: 1",),
    ),
    "head_ct_phantom/tilted_S3010": (
        ("CT", (512, 612, 58), (0.406, 0.406, 2.397), "HU"),
        ("files without an image plane were skipped: 1", "the stack leaned by 16.5 deg"),
    ),
    "chest_ct/P002": (("CT", (512, 512, 133), (0.604, 0.604, 2.0), "HU"), ()),
    "abdomen_ct/example_ct.nii.gz": (
        ("CT", (122, 101, 112), (3, 3, 3), "HU"),
        ("the volume file does not name", "124 voxels below -1024", "114 voxels above 3071"),
    ),
    "chest_ct/normal001_half.nii.gz": (
        ("CT", (256, 256, 154), (1.270, 1.270, 2.0), "HU"),
        ("the volume file does not name",),
    ),
    "head_mri/chris_t1.nii.gz": (("MR", (188, 256, 190), (0.88, 0.88, 0.88), "intensity"), ()),
}


@pytest.mark.parametrize("image", IMAGES)
def test_real_images_have_their_shape_spacing_unit_and_notices(test_data, image):
    (modality, shape, spacing, unit), notices = IMAGES[image]
    volume = read(test_data / image, modality)
    assert volume.voxels.shape == shape and volume.unit == unit
    assert volume.voxels.dtype == np.int16
    np.testing.assert_allclose(spacing_mm(volume.patient_from_index), spacing, atol=5e-4)
    assert len(volume.origin.notices) == len(notices)
    for notice, start in zip(volume.origin.notices, notices, strict=True):
        assert notice.startswith(start)


def test_the_tilted_head_has_the_bone_of_the_straight_one(test_data):
    """Read as if they lay straight above each other, the tilted planes would show
    1 / cos 16.5 deg = 1.043 times as much."""
    straight, tilted = (
        read(test_data / "head_ct_phantom" / name, "CT")
        for name in ("straight_S2020", "tilted_S3010")
    )
    scans = lay_together(straight, tilted, every=2)
    assert scans.shared.mean() > 0.3
    for threshold_hu in (150, 200, 300, 400, 500, 600):
        assert bone_ratio(scans, threshold_hu) == pytest.approx(1, abs=0.02), threshold_hu
