"""What a DICOM file says of each of its planes: one header for each frame, by keyword.

A classic file holds one plane and says all at the top. An enhanced one (DICOM PS3.3 C.7.6.16)
holds many, and says what is common to all in its shared functional groups and the rest in the
groups of each frame. Private groups (Philips keeps a second, differing place there) are not read.
"""

from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float

from catalog.formats.dicom_pixels import frame_count
from nodes.imaging.series_key import series_key

if TYPE_CHECKING:
    from pydicom import Dataset

Header = dict[str, Any]

# Largest cosine between rows and columns; scanners write directions with 6 digits.
_RIGHT_ANGLE = 1e-3
# What a plane with a place must have (DICOM PS3.3 C.7.6.2 and C.7.6.3).
PLACE = ("ImagePositionPatient", "ImageOrientationPatient", "PixelSpacing")
NEEDED = (*PLACE, "RescaleSlope", "RescaleIntercept", "RescaleType")
# What tells planes at one place apart, and how people read it.
MEASURES = (
    (("EffectiveEchoTime", "EchoTime"), "echo {} ms"),
    (("DiffusionBValue",), "b {}"),
    (("DiffusionGradientOrientation",), "along {}"),
    (("TemporalPositionIndex", "TemporalPositionIdentifier"), "moment {}"),
    (("NominalCardiacTriggerDelayTime", "TriggerTime"), "trigger {} ms"),
)
KIND = (
    "ImageType",
    "FrameType",
    "StackID",
    "AcquisitionNumber",
    "FrameAcquisitionNumber",
    *(keyword for keywords, _ in MEASURES for keyword in keywords),
)
# Words of image types that DICOM defines and that people know; a scanner's own are hashed.
PLAIN_WORDS = frozenset({
    "ORIGINAL", "DERIVED", "PRIMARY", "SECONDARY", "AXIAL", "LOCALIZER", "OTHER", "NONE", "VOLUME",
    "M", "P", "R", "I", "MAGNITUDE", "PHASE", "REAL", "IMAGINARY", "SE", "FFE", "M_SE", "M_FFE",
    "MPR", "MIP", "REFORMATTED", "ADC", "FA", "TRACE", "DIFFUSION", "T1", "T2", "WATER", "FAT",
    "IN_PHASE", "OUT_OF_PHASE",
})  # fmt: skip


def plane_headers(dataset: "Dataset") -> list[Header]:
    """Return the header of each frame; none where it holds no grey pictures with a place."""
    if not _is_grey(dataset):
        return []
    common = dict.fromkeys((*NEEDED, *KIND)) | _read(dataset)
    groups = dataset.get("PerFrameFunctionalGroupsSequence") or ()
    if not groups:
        headers = [common] if frame_count(dataset) == 1 else []
    else:
        if frame_count(dataset) > 1:  # one place for all would be a lie
            common["ImagePositionPatient"] = None
        for group in dataset.get("SharedFunctionalGroupsSequence") or ():
            common |= _read_group(group)
        if len(groups) != frame_count(dataset):
            raise ValueError(f"{len(groups)} groups for {frame_count(dataset)} frames")
        headers = [common | _read_group(group) for group in groups]
    complete = all(header[keyword] is not None for header in headers for keyword in PLACE)
    return headers if complete else []


def _is_grey(dataset: "Dataset") -> bool:
    """Return whether it holds grey pictures of a body: no colours, and no masks."""
    return (
        "PixelData" in dataset
        and int(dataset.get("SamplesPerPixel", 1)) == 1
        and int(dataset.BitsAllocated) >= 8
        and str(dataset.get("PhotometricInterpretation", "")) != "PALETTE COLOR"
        and str(dataset.get("Modality", "")) != "SEG"
    )


def _read_group(group: "Dataset") -> Header:
    """Return what one functional group says of the wanted keywords."""
    sequences = (item for item in group if item.VR == "SQ" and not item.tag.is_private)
    found: Header = {}
    for sequence in sequences:
        found |= _read(sequence.value[0]) if sequence.value else {}
    return found


def _read(part: "Dataset") -> Header:
    """Return the wanted values that are there; one of kind that cannot be read is left out."""
    header = {keyword: part.get(keyword) for keyword in NEEDED}
    for keyword in KIND:
        with suppress(TypeError, ValueError):
            header[keyword] = part.get(keyword)
    return {keyword: value for keyword, value in header.items() if value is not None}


def patient_from_pixel(header: Header) -> Float[np.ndarray, "4 4"]:
    """Return DICOM PS3.3 eq. C.7.6.2.1-1, with the unit normal as third column.

    Raises ValueError where the header gives no grid of numbers with right angles.
    """
    orientation = np.asarray(header["ImageOrientationPatient"], float).reshape(2, 3)
    along_row, along_column = orientation / np.linalg.norm(orientation, axis=1, keepdims=True)
    between_rows, between_columns = (float(value) for value in header["PixelSpacing"])
    normal = np.cross(along_row, along_column)
    matrix = np.eye(4)
    matrix[:3, 0] = along_row * between_columns
    matrix[:3, 1] = along_column * between_rows
    matrix[:3, 2] = normal / np.linalg.norm(normal)
    matrix[:3, 3] = np.asarray(header["ImagePositionPatient"], float)
    skewed = abs(along_row @ along_column) > _RIGHT_ANGLE
    if skewed or not np.isfinite(matrix).all() or min(between_rows, between_columns) <= 0:
        raise ValueError("no grid with right angles")
    return matrix


def describe_kind(header: Header) -> str:
    """Return in words what tells the plane apart from others at its place."""
    parts = [" ".join(_plain(word) for word in _image_type(header)).lower()]
    for keywords, words in MEASURES:
        numbers = next((found for k in keywords if (found := _numbers(header[k]))), [])
        if numbers:
            parts.append(words.format(" ".join(f"{number:.4g}" for number in numbers)))
    if header["StackID"]:
        parts.append(f"stack {_plain(str(header['StackID']))}")
    return ", ".join(part for part in parts if part)


def _numbers(value: object) -> list[float]:
    """Return one number or several, none where there are none or other words."""
    try:
        return [] if value is None else list(np.atleast_1d(np.asarray(value, float)) + 0.0)
    except (TypeError, ValueError):
        return []


def _image_type(header: Header) -> list[str]:
    value = header["FrameType"] or header["ImageType"] or ()
    return [value] if isinstance(value, str) else [str(word) for word in value]


def acquisition_number(header: Header) -> int:
    """Return the number of the acquisition, 0 where none is given."""
    numbers = _numbers(header["FrameAcquisitionNumber"]) or _numbers(header["AcquisitionNumber"])
    return int(numbers[0]) if numbers else 0


def _plain(word: str) -> str:
    short_number = word.isdigit() and len(word) < 4
    return word if word in PLAIN_WORDS or short_number else series_key(word)
