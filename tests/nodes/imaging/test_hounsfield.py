"""When values are HU: known from the files, vouched for by a person, and else never claimed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodes.errors import BadInput
from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin
from nodes.imaging.artefacts import ImageFiles
from nodes.imaging.read_volume import read_volume
from tests.nodes.imaging.made_planes import read, settings_of, stack


def file_with(lowest, highest, kind=np.int16, **changed):
    voxels = np.linspace(lowest, highest, 60).astype(kind).reshape(3, 4, 5)
    volume = Volume(voxels, np.eye(4), "intensity", Origin("volume file"))
    return read_volume(ImageFiles((), volume), settings_of(**changed))


def series_with(lowest, highest, unit="HU", **changed):
    planes = stack(range(4), lambda points: 0 * points[..., 0], unit=unit)
    values = np.linspace(lowest, highest, planes[0].pixels.size).astype(np.int16)
    pixels = values.reshape(planes[0].pixels.shape)
    return read([type(p)(pixels, p.patient_from_pixel, 1, "CT", unit) for p in planes], **changed)


def test_a_volume_file_with_air_is_taken_for_hu_with_notice():
    volume = file_with(-1000, 2000)
    assert volume.unit == "HU"
    assert volume.origin.notices == ("the volume file does not name its unit; HU are assumed",)


@pytest.mark.parametrize(("lowest", "highest"), [(0, 4095), (-1, 1), (-200, 300), (900, 1100)])
def test_a_volume_file_without_air_stays_intensity_and_the_cure_is_named(lowest, highest):
    volume = file_with(lowest, highest, np.float32)
    assert volume.unit == "intensity"
    (notice,) = volume.origin.notices
    assert notice.startswith(f"values from {lowest} to {highest} ") and "hu_offset" in notice
    assert volume.voxels.min() == lowest


def test_an_8_bit_picture_is_told_apart_from_an_offset():
    (notice,) = file_with(0, 255).origin.notices
    assert "8-bit picture" in notice and "hu_offset" not in notice


def test_values_of_an_mr_are_never_hu():
    volume = file_with(-1000, 2000, modality="MR")
    assert volume.unit == "intensity" and volume.origin.notices == ()
    assert file_with(-1000, 2000, modality="any").unit == "intensity"


def test_a_ct_series_is_hu_as_its_files_say():
    volume = series_with(-120, 300)
    assert volume.unit == "HU" and volume.origin.notices == ()


@pytest.mark.parametrize("unit", ["HU", "intensity"])
def test_a_ct_series_with_a_forgotten_offset_is_not_hu_until_a_person_gives_it(unit):
    plain = series_with(0, 4095, unit)
    assert plain.unit == "intensity" and "hu_offset" in plain.origin.notices[0]
    mended = series_with(0, 4095, unit, hu_offset=-1024)
    assert mended.unit == "HU" and (mended.voxels.min(), mended.voxels.max()) == (-1024, 3071)
    assert mended.origin.notices == ("values became HU by the parameter hu_offset (-1024)",)
    np.testing.assert_array_equal(mended.voxels, plain.voxels - 1024)


def test_a_series_without_a_scale_is_not_hu_even_if_it_could_be():
    assert series_with(-1000, 2000, "intensity").unit == "intensity"
    assert series_with(-1000, 2000, "intensity", hu_offset=0).unit == "HU"


@pytest.mark.parametrize("make", [file_with, series_with])
def test_an_offset_for_what_is_hu_already_is_refused(make):
    with pytest.raises(BadInput, match="hu_offset -1024 for values from -1000"):
        make(-1000, 2000, hu_offset=-1024)
    assert make(-1000, 2000, hu_offset=0).unit == "HU"


@pytest.mark.parametrize("kind", [np.int16, np.float32])
def test_extremes_are_clipped_below_and_kept_above_and_counted(kind):
    voxels = np.full((3, 4, 5), 7, kind)
    voxels[0, 0, :3] = [-3024, -1025, -1024]
    voxels[1, 1, :3] = [3071, 3072, 30000]
    volume = read_volume(
        ImageFiles((), Volume(voxels, np.eye(4), "intensity", Origin("x"))), settings_of()
    )
    assert volume.voxels.dtype == kind
    assert [notice.split(" HU")[0] for notice in volume.origin.notices[1:]] == [
        "2 voxels below -1024",
        "2 voxels above 3071",
    ]
    np.testing.assert_array_equal(volume.voxels, np.maximum(voxels, -1024))


@given(st.integers(-8192, 0), st.integers(0, 32767))
def test_an_offset_never_wraps_around(offset, highest):
    volume = file_with(0, highest, hu_offset=offset)
    assert volume.voxels.max() == max(highest + offset, -1024)
    assert volume.voxels.min() == max(offset, -1024)
    lowest = series_with(-32768, highest, "intensity", hu_offset=offset)
    assert lowest.voxels.min() == -1024 and lowest.voxels.max() == max(highest + offset, -1024)
