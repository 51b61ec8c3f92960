"""Pixels of DICOM files: unpacked exactly, one frame or many, and missing ones noticed."""

from io import BytesIO

import numpy as np
import pydicom
import pytest

from catalog.formats.image_files import ImageFilesFormat
from nodes.errors import BadInput
from nodes.imaging.artefacts import ImageFiles
from tests.catalog.formats.enhanced import decode, enhanced_file, planes

PACKINGS = ["", "rle", "JPEG", "JPEG2000"]


@pytest.mark.parametrize("packed", PACKINGS)
@pytest.mark.parametrize("count", [1, 3])
def test_packed_frames_are_unpacked_exactly(packed, count):
    made = planes(count, shape=(64, 72))
    read = decode(enhanced_file(made, packed=packed))
    assert len(read) == count
    for one, other in zip(read, made, strict=True):
        np.testing.assert_array_equal(one.pixels, other.pixels)


def test_noise_that_run_lengths_made_larger_is_read():
    made = planes(2, shape=(5, 7))
    for one, other in zip(decode(enhanced_file(made, packed="rle")), made, strict=True):
        np.testing.assert_array_equal(one.pixels, other.pixels)


@pytest.mark.parametrize("packed", PACKINGS)
@pytest.mark.parametrize("frames", [2, 5])
def test_frames_that_are_missing_are_damage(packed, frames):
    content = enhanced_file(planes(4, shape=(64, 72)), packed=packed, NumberOfFrames=frames)
    with pytest.raises(BadInput, match="file 1 of 1"):
        decode(content)


@pytest.mark.parametrize("packed", PACKINGS)
@pytest.mark.parametrize("share", [0.4, 0.8, 0.98])
def test_a_cut_off_enhanced_file_is_refused(packed, share):
    content = enhanced_file(planes(4, shape=(64, 72)), packed=packed)
    with pytest.raises(BadInput, match="cut off or damaged"):
        decode(content[: int(len(content) * share)])


@pytest.mark.parametrize(
    ("signed", "stored", "meant"),
    [
        (0, [0x8064, 0x10C8, 4095, 7], [100, 200, 4095, 7]),  # an overlay in the unused bits
        (1, [0x0FFF, 0x0800, 0x07FF, 5], [-1, -2048, 2047, 5]),  # signs in the twelfth bit
    ],
)
def test_only_the_stored_bits_count(signed, stored, meant):
    content = ImageFilesFormat.encode(ImageFiles(tuple(planes(1, shape=(2, 2)))))
    dataset = pydicom.dcmread(BytesIO(content["slice_0001.dcm"]))
    dataset.PixelRepresentation, dataset.BitsStored, dataset.HighBit = signed, 12, 11
    dataset.PixelData = np.array(stored, "<u2").tobytes()
    file = BytesIO()
    dataset.save_as(file)
    np.testing.assert_array_equal(decode(file.getvalue())[0].pixels.ravel(), meant)
