"""Image files as scanners and other programs write them: DICOM series and single volume files.

Only geometry, modality and pixel values leave a file: no name, id, date or UID of a person. For
the same reason errors count files in the order of their names instead of showing the names.
"""

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Shaped

from catalog.formats import dicom_writer, itk_files
from nodes.errors import BadInput
from nodes.imaging.artefacts import ImageFiles, Slice

if TYPE_CHECKING:
    from pydicom import Dataset

# Names that promise DICOM; exports without a suffix are known by their content.
DICOM_SUFFIXES = (".dcm", ".dicom", ".ima")
# What a file must hold to be a plane with a place (DICOM PS3.3 C.7.6.2 and C.7.6.3).
PLANE = ("ImagePositionPatient", "ImageOrientationPatient", "PixelSpacing", "Rows", "Columns")
# CT, enhanced CT, MR and enhanced MR image storage (DICOM PS3.4 B.5): a whole file has pixels.
IMAGE_STORAGE = tuple(f"1.2.840.10008.5.1.4.1.1.{end}" for end in ("2", "2.1", "4", "4.1"))


class ImageFilesFormat:
    """A folder of DICOM files in any nesting, or one NIfTI, NRRD or MetaImage file."""

    @staticmethod
    def encode(value: ImageFiles) -> dict[str, bytes]:
        """Write each plane as a DICOM file, or the volume as a MetaImage; skipped files are gone.

        Equal values give equal bytes: UIDs come from the content, dates are made up.
        """
        if value.volume is not None:
            return {"volume.mha": itk_files.write_volume(value.volume)}
        return dicom_writer.write_planes(value.slices, value.simulated)

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> ImageFiles:
        """Read all planes, or else the one volume file; raises BadInput where there is neither,
        where there are both or several, and for a file that cannot be read."""
        with _silent_pydicom():
            return _decode(files)


@contextmanager
def _silent_pydicom() -> Iterator[None]:
    """Keep pydicom's warnings to ourselves: they quote values, which may be identifiers.

    It warns in both ways that Python has, and whoever sets up logging (Prefect does) prints them.
    """
    import warnings

    from pydicom import config

    level = config.logger.level
    config.logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        config.logger.setLevel(level)


def _decode(files: Mapping[str, bytes]) -> ImageFiles:
    planes = list(_read_planes(files))
    volumes = [name for name in sorted(files) if itk_files.is_volume_name(name)]
    if len(volumes) + bool(planes) > 1:
        raise BadInput(
            f"{len(volumes)} volume files and {len(planes)} DICOM planes",
            "the input is one volume file or a folder of DICOM files",
            "leave only one of them in the folder",
        )
    if volumes:
        companions = itk_files.companions(volumes[0], files)
        skipped = len(files) - len(companions)
        return ImageFiles((), itk_files.read_volume(volumes[0], companions), skipped)
    if not planes:
        raise _nothing_to_read(len(files))
    return ImageFiles(
        slices=_slices(planes, len(files)),
        skipped=len(files) - len(planes),
        simulated=any(_is_simulated(dataset) for _, dataset in planes),
    )


def _read_planes(files: Mapping[str, bytes]) -> Iterator[tuple[int, "Dataset"]]:
    """Yield each file with an image plane, with its number in the order of names, from 1."""
    for number, name in enumerate(sorted(files), start=1):
        content = files[name]
        if not _is_dicom(content) or PurePosixPath(name).name.upper() == "DICOMDIR":
            suffix = PurePosixPath(name).suffix.lower()
            if suffix in DICOM_SUFFIXES or not (content or suffix):
                raise _unreadable(number, len(files))  # left out, the anatomy would be cut short
            continue
        try:
            dataset = _read_dataset(content)
            cut_off, plane = _is_cut_off(dataset), _is_plane(dataset)
        except Exception:  # whatever breaks in a broken file; its message may quote identifiers
            raise _unreadable(number, len(files)) from None
        if cut_off:
            raise _unreadable(number, len(files))
        if plane:
            yield number, dataset


def _is_dicom(content: bytes) -> bool:
    """A preamble (DICOM PS3.10 7.1), or, in old files without one, an element of group 8 first."""
    return content[128:132] == b"DICM" or content[:2] == b"\x08\x00"


def _read_dataset(content: bytes) -> "Dataset":
    from io import BytesIO

    import pydicom
    from pydicom.uid import ImplicitVRLittleEndian

    dataset = pydicom.dcmread(BytesIO(content), force=True)
    if "TransferSyntaxUID" not in dataset.file_meta:  # the default, DICOM PS3.5 10.1
        dataset.file_meta.TransferSyntaxUID = ImplicitVRLittleEndian
    return dataset


def _is_cut_off(dataset: "Dataset") -> bool:
    """Return whether an image lacks its pixels or, uncompressed, some of them."""
    if "PixelData" not in dataset:
        kind = dataset.file_meta.get("MediaStorageSOPClassUID", "")
        return "Rows" in dataset or kind in IMAGE_STORAGE
    if _is_compressed(dataset):
        return False
    samples = dataset.Rows * dataset.Columns * dataset.get("SamplesPerPixel", 1)
    bits = samples * int(dataset.get("NumberOfFrames") or 1) * dataset.BitsAllocated
    return len(dataset.PixelData) * 8 < bits


def _is_compressed(dataset: "Dataset") -> bool:
    syntax = dataset.file_meta.TransferSyntaxUID
    return syntax.is_compressed and not syntax.is_deflated


def _is_plane(dataset: "Dataset") -> bool:
    """Return whether it is one grey image with a place; enhanced files keep places elsewhere."""
    return (
        all(dataset.get(keyword) is not None for keyword in PLANE)
        and "PixelData" in dataset
        and int(dataset.get("NumberOfFrames") or 1) == 1
        and int(dataset.get("SamplesPerPixel", 1)) == 1
    )


def _is_simulated(dataset: "Dataset") -> bool:
    return dataset.get("SeriesDescription", "") == dicom_writer.SIMULATED


def _slices(planes: list[tuple[int, "Dataset"]], count: int) -> tuple[Slice, ...]:
    series: dict[str, int] = {}
    slices = []
    for number, dataset in planes:
        uid = str(dataset.get("SeriesInstanceUID", ""))
        index = series.setdefault(uid, len(series) + 1)
        try:
            slices.append(_slice(dataset, index))
        except Exception:  # as above: any decoder's complaint about any broken file
            raise _unreadable(number, count) from None
    return tuple(slices)


def _slice(dataset: "Dataset", series: int) -> Slice:
    modality = str(dataset.get("Modality", "OT"))
    return Slice(
        pixels=_rescaled(_stored_pixels(dataset), dataset),
        patient_from_pixel=_patient_from_pixel(dataset),
        series=series,
        modality=modality,
        unit="HU" if modality == "CT" and _has_hounsfield_scale(dataset) else "intensity",
    )


def _has_hounsfield_scale(dataset: "Dataset") -> bool:
    """Rescaled CT values are HU unless the file says otherwise (DICOM PS3.3 C.8.2.1.1.3)."""
    return "RescaleSlope" in dataset and (dataset.get("RescaleType") or "HU") == "HU"


def _stored_pixels(dataset: "Dataset") -> Shaped[np.ndarray, "rows columns"]:
    """Return the values as stored; no plug-in of pydicom for JPEG is here, so ITK unpacks."""
    return itk_files.unpack_pixels(dataset) if _is_compressed(dataset) else dataset.pixel_array


def _rescaled(
    stored: Shaped[np.ndarray, "rows columns"], dataset: "Dataset"
) -> Shaped[np.ndarray, "rows columns"]:
    """Apply slope and intercept (DICOM PS3.3 C.11.1); whole numbers stay int16 where they fit."""
    slope = float(dataset.get("RescaleSlope", 1))
    values = stored * slope + float(dataset.get("RescaleIntercept", 0))
    limits = np.iinfo(np.int16)
    fits = limits.min <= values.min() and values.max() <= limits.max
    whole = slope.is_integer() and bool(np.all(values == np.rint(values)))
    return values.astype(np.int16 if whole and fits else np.float32)


def _patient_from_pixel(dataset: "Dataset") -> Float[np.ndarray, "4 4"]:
    """Return DICOM PS3.3 eq. C.7.6.2.1-1, with the unit normal as third column."""
    along_row, along_column = np.asarray(dataset.ImageOrientationPatient, float).reshape(2, 3)
    between_rows, between_columns = (float(value) for value in dataset.PixelSpacing)
    normal = np.cross(along_row, along_column)
    matrix = np.eye(4)
    matrix[:3, 0] = along_row * between_columns
    matrix[:3, 1] = along_column * between_rows
    matrix[:3, 2] = normal / np.linalg.norm(normal)
    matrix[:3, 3] = np.asarray(dataset.ImagePositionPatient, float)
    return matrix


def _nothing_to_read(files: int) -> BadInput:
    return BadInput(
        f"{files} files, none with an image plane",
        "DICOM images are grey, one plane a file, with position, orientation and pixel spacing;"
        " or there is one .nii, .nii.gz, .nrrd, .nhdr, .mha or .mhd file",
        "name the folder that holds the image series, or convert it to NIfTI",
    )


def _unreadable(number: int, count: int) -> BadInput:
    return BadInput(
        f"file {number} of {count} (in the order of their names) is cut off or damaged",
        "every image file is whole",
        "export or copy it again",
    )
