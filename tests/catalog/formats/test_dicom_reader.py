"""From DICOM files to planes: which files count, and what they keep to themselves."""

from io import BytesIO

import numpy as np
import pydicom
import pytest

from catalog.formats.image_files import ImageFilesFormat
from nodes.errors import BadInput
from nodes.imaging.artefacts import ImageFiles
from nodes.imaging.series_key import series_key
from tests.catalog.formats.enhanced import decode, enhanced_file, planes


def changed(**elements) -> bytes:
    """A classic CT file with these elements set, or taken out where they are None."""
    files = ImageFilesFormat.encode(ImageFiles(tuple(planes(1))))
    dataset = pydicom.dcmread(BytesIO(files["slice_0001.dcm"]))
    for keyword, value in elements.items():
        if value is None:
            delattr(dataset, keyword)
        else:
            setattr(dataset, keyword, value)
    file = BytesIO()
    dataset.save_as(file)
    return file.getvalue()


def test_the_series_is_known_by_a_hash_of_its_uid():
    uid = "1.2.840.99999.4711"
    (plane,) = decode(changed(SeriesInstanceUID=uid))
    assert plane.series_key == series_key(uid)
    assert uid not in repr(plane)


def test_two_patients_with_one_uid_are_two_series_and_stay_unnamed():
    files = {
        f"{n}.dcm": changed(SeriesInstanceUID="1.2.3", PatientID=who, InstanceNumber=n)
        for n, who in enumerate(["A-1717", "A-1717", "B-9"])
    }
    slices = ImageFilesFormat.decode(files).slices
    assert [plane.series for plane in slices] == [1, 1, 2]
    assert "1717" not in repr(slices)


def test_what_tells_stacks_apart_is_read_in_words():
    (plane,) = decode(
        changed(
            ImageType=["ORIGINAL", "PRIMARY", "M", "JANE"],
            EchoTime="4.60",
            TemporalPositionIdentifier=2,
            AcquisitionNumber=3,
        )
    )
    words = f"original primary m {series_key('JANE')}"
    assert plane.kind == f"{words}, echo 4.6 ms, moment 2"
    assert plane.acquisition == 3


def test_words_that_cannot_be_read_do_not_spoil_a_plane():
    content = changed(EchoTime="4.60", AcquisitionNumber=3).replace(b"4.60", b"none")
    assert b"none" in content
    (plane,) = decode(content)
    assert "echo" not in plane.kind


@pytest.mark.parametrize(
    ("scale", "unit"),
    [(("1", "-1024", "HU"), "HU"), (("1", "-1024", None), "HU"), (("1", "0", "US"), "intensity"),
     ((None, None, None), "intensity")],
)  # fmt: skip
def test_a_ct_is_hu_where_it_has_a_scale_to_hu(scale, unit):
    elements = dict(zip(("RescaleSlope", "RescaleIntercept", "RescaleType"), scale, strict=True))
    (plane,) = decode(changed(**{key: value for key, value in elements.items() if value}))
    assert plane.unit == unit


def test_maps_of_measures_are_skipped():
    """Parametric maps keep float pixels elsewhere; a file that lost its pixels is damage."""
    dataset = pydicom.dcmread(BytesIO(enhanced_file(planes(2))))
    dataset.FloatPixelData = np.zeros(70, np.float32).tobytes()
    del dataset.PixelData
    file = BytesIO()
    dataset.file_meta.MediaStorageSOPClassUID = dataset.SOPClassUID = "1.2.840.10008.5.1.4.1.1.30"
    dataset.save_as(file)
    files = {"map": file.getvalue(), "b": enhanced_file(planes(3))}
    again = ImageFilesFormat.decode(files)
    assert len(again.slices) == 3 and again.skipped == 1
    with pytest.raises(BadInput, match="cut off or damaged"):
        decode(changed(PixelData=None))


def test_classic_and_enhanced_files_of_one_folder_are_two_series():
    files = ImageFilesFormat.encode(ImageFiles(tuple(planes(4))))
    decoded = ImageFilesFormat.decode({**files, "z": enhanced_file(planes(3))})
    assert [plane.series for plane in decoded.slices] == [1] * 4 + [2] * 3


@pytest.mark.parametrize(
    "elements",
    [
        {"ImageOrientationPatient": ["0"] * 6},
        {"PixelSpacing": ["0", "1"]},
        {"ImageOrientationPatient": ["1", "0", "0", "0.2", "0.98", "0"]},
        {"ImageOrientationPatient": ["1", "0", "0", "1", "0", "0"]},
    ],
)
def test_directions_that_are_no_grid_are_damage(elements):
    with pytest.raises(BadInput, match="file 1 of 1"):
        decode(changed(**elements))
