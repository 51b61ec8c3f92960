"""Pixel values of DICOM images, packed or not, one frame at a time."""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Shaped

from catalog.formats.native_words import native_words

if TYPE_CHECKING:
    from pydicom import Dataset

# All that a decoder of pixels needs to know (DICOM PS3.3 C.7.6.3).
PIXEL_MODULE = (
    "SamplesPerPixel",
    "PhotometricInterpretation",
    "Rows",
    "Columns",
    "BitsAllocated",
    "BitsStored",
    "HighBit",
    "PixelRepresentation",
)


def is_compressed(dataset: "Dataset") -> bool:
    """Return whether the pixels are packed frame by frame."""
    syntax = dataset.file_meta.TransferSyntaxUID
    return syntax.is_compressed and not syntax.is_deflated


def frame_count(dataset: "Dataset") -> int:
    """Return the number of frames; files without that element have one."""
    return int(dataset.get("NumberOfFrames") or 1)


def is_cut_off(dataset: "Dataset") -> bool:
    """Return whether unpacked pixels are fewer than the header says; packed ones show it later."""
    if is_compressed(dataset):
        return False
    samples = dataset.Rows * dataset.Columns * dataset.get("SamplesPerPixel", 1)
    bits = samples * frame_count(dataset) * dataset.BitsAllocated
    return len(dataset.PixelData) * 8 < bits


def stored_frames(dataset: "Dataset") -> list[Shaped[np.ndarray, "rows columns"]]:
    """Return each frame's values as stored; pydicom unpacks run lengths, and ITK all JPEG kinds.

    Raises whatever a decoder raises where the pixels are damaged. Frames may be missing.
    """
    from pydicom.uid import RLELossless

    # ITK refuses frames that run lengths made larger, as they do to noise.
    if is_compressed(dataset) and dataset.file_meta.TransferSyntaxUID != RLELossless:
        return [_unpack(dataset, packed) for packed in _packed_frames(dataset)]
    return list(dataset.pixel_array.reshape(-1, dataset.Rows, dataset.Columns))


def _packed_frames(dataset: "Dataset") -> Iterator[bytes]:
    from pydicom.encaps import generate_frames

    offsets = None
    if "ExtendedOffsetTable" in dataset:
        offsets = dataset.ExtendedOffsetTable, dataset.ExtendedOffsetTableLengths
    count = frame_count(dataset)
    return generate_frames(dataset.PixelData, number_of_frames=count, extended_offsets=offsets)


def _unpack(dataset: "Dataset", packed: bytes) -> Shaped[np.ndarray, "rows columns"]:
    """Return the stored values of one packed frame; raises where ITK cannot unpack it.

    ITK reads from disk only. The scratch file holds the pixels and how they are packed, and
    nothing else of the dataset.
    """
    import SimpleITK as sitk
    from pydicom import Dataset
    from pydicom.dataset import FileMetaDataset
    from pydicom.encaps import encapsulate
    from pydicom.uid import SecondaryCaptureImageStorage

    bare = Dataset()
    for keyword in PIXEL_MODULE:
        bare[keyword] = dataset[keyword]
    bare.SOPClassUID, bare.SOPInstanceUID = SecondaryCaptureImageStorage, "2.25.1"
    bare.PixelData = encapsulate([packed])
    bare["PixelData"].is_undefined_length = True
    bare.file_meta = FileMetaDataset()
    bare.file_meta.TransferSyntaxUID = dataset.file_meta.TransferSyntaxUID
    with TemporaryDirectory() as scratch:
        path = Path(scratch) / "plane.dcm"
        bare.save_as(path, enforce_file_format=True)
        with native_words() as words:
            pixels = sitk.GetArrayFromImage(sitk.ReadImage(str(path)))[0]
            if b"Corrupt" in words():
                raise ValueError("the decoder found damaged pixels")
        return pixels
