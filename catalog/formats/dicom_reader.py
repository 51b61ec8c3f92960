"""From the bytes of a DICOM file to its planes, without any identifier."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Shaped

from catalog.formats import dicom_headers
from catalog.formats.dicom_headers import Header
from catalog.formats.dicom_pixels import is_cut_off, stored_frames
from nodes.imaging.artefacts import Slice
from nodes.imaging.series_key import series_key

if TYPE_CHECKING:
    from pydicom import Dataset

# CT, enhanced CT, MR and enhanced MR image storage (DICOM PS3.4 B.5): a whole file has pixels.
IMAGE_STORAGE = tuple(f"1.2.840.10008.5.1.4.1.1.{end}" for end in ("2", "2.1", "4", "4.1"))
# Pixels of maps of measures, which are not grey pictures (DICOM PS3.3 C.7.6.24).
FLOAT_PIXELS = ("FloatPixelData", "DoubleFloatPixelData")


def is_dicom(content: bytes) -> bool:
    """A preamble (DICOM PS3.10 7.1), or, in old files without one, an element of group 8 first."""
    return content[128:132] == b"DICM" or content[:2] == b"\x08\x00"


def read_dataset(content: bytes) -> "Dataset":
    """Return the file's dataset, with a transfer syntax also where an old file names none."""
    from io import BytesIO

    import pydicom
    from pydicom.uid import ImplicitVRLittleEndian

    dataset = pydicom.dcmread(BytesIO(content), force=True)
    if "TransferSyntaxUID" not in dataset.file_meta:  # the default, DICOM PS3.5 10.1
        dataset.file_meta.TransferSyntaxUID = ImplicitVRLittleEndian
    return dataset


def read_slices(dataset: "Dataset", series: dict[str, int]) -> tuple[Slice, ...]:
    """Return the planes of a file, none where it holds no grey image with a place.

    Parameters
    ----------
    series : numbers of the series by UID and patient; a new one is entered.

    Raises
    ------
    Whatever pydicom or a decoder raises, and ValueError, where the file is damaged or cut off.
    """
    if "PixelData" not in dataset:
        _refuse_lost_pixels(dataset)
        return ()
    if is_cut_off(dataset):
        raise ValueError("fewer pixels than the header says")
    headers = dicom_headers.plane_headers(dataset)
    if not headers:
        return ()
    uid = str(dataset.get("SeriesInstanceUID", ""))
    # Bad anonymisers give two patients one UID; who they are is compared and not kept.
    patient = f"{dataset.get('PatientID', '')}|{dataset.get('PatientName', '')}"
    number = series.setdefault(f"{uid}|{patient}", len(series) + 1)
    modality = str(dataset.get("Modality", "OT"))
    return tuple(
        _slice(stored, header, number, series_key(uid), modality)
        for stored, header in zip(stored_frames(dataset), headers, strict=True)
    )


def _refuse_lost_pixels(dataset: "Dataset") -> None:
    kind = dataset.file_meta.get("MediaStorageSOPClassUID", "")
    sized = "Rows" in dataset and not any(keyword in dataset for keyword in FLOAT_PIXELS)
    if sized or kind in IMAGE_STORAGE:
        raise ValueError("an image without pixels")


def _slice(
    stored: Shaped[np.ndarray, "rows columns"],
    header: Header,
    series: int,
    key: str,
    modality: str,
) -> Slice:
    return Slice(
        pixels=_rescaled(stored, header),
        patient_from_pixel=dicom_headers.patient_from_pixel(header),
        series=series,
        modality=modality,
        unit="HU" if modality == "CT" and _has_hounsfield_scale(header) else "intensity",
        series_key=key,
        kind=dicom_headers.describe_kind(header),
        acquisition=dicom_headers.acquisition_number(header),
    )


def _has_hounsfield_scale(header: Header) -> bool:
    """Rescaled CT values are HU unless the file says otherwise (DICOM PS3.3 C.8.2.1.1.3)."""
    return header["RescaleSlope"] is not None and (header["RescaleType"] or "HU") == "HU"


def _rescaled(
    stored: Shaped[np.ndarray, "rows columns"], header: Header
) -> Shaped[np.ndarray, "rows columns"]:
    """Apply slope and intercept (DICOM PS3.3 C.11.1); whole numbers stay int16 where they fit."""
    slope = _number(header["RescaleSlope"], 1.0)
    values = stored * slope + _number(header["RescaleIntercept"], 0.0)
    limits = np.iinfo(np.int16)
    fits = limits.min <= values.min() and values.max() <= limits.max
    whole = slope.is_integer() and bool(np.all(values == np.rint(values)))
    return values.astype(np.int16 if whole and fits else np.float32)


def _number(value: object, otherwise: float) -> float:
    return otherwise if value is None else float(value)  # type: ignore[arg-type]
