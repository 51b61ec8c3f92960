"""Image files as scanners and other programs write them: DICOM series and single volume files.

Only geometry, modality and pixel values leave a file: no name, id, date or UID of a person. For
the same reason errors count files in the order of their names instead of showing the names.
"""

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import PurePosixPath

from catalog.formats import dicom_reader, dicom_writer, itk_files
from nodes.errors import BadInput
from nodes.imaging.artefacts import ImageFiles, Slice

# Names that promise DICOM; exports without a suffix are known by their content.
DICOM_SUFFIXES = (".dcm", ".dicom", ".ima")
# Volumes of other kinds: said so, since "nothing to read" would puzzle their owner.
FOREIGN_SUFFIXES = (".mgz", ".mgh", ".img", ".hdr", ".mnc", ".par", ".rec", ".xml.gz", ".vtk")


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
    contents = _dicom_contents(files)
    planes, simulated = _read_planes(contents, len(files))
    slices = tuple(plane for frames in planes for plane in frames)
    volumes = [name for name in sorted(files) if itk_files.is_volume_name(name)]
    if len(volumes) + bool(planes) > 1:
        raise BadInput(
            f"{len(volumes)} volume files and {len(slices)} DICOM planes",
            "the input is one volume file or a folder of DICOM files",
            "leave only one of them in the folder",
        )
    if volumes:
        companions = itk_files.companions(volumes[0], files)
        skipped = len(files) - len(companions)
        return ImageFiles((), itk_files.read_volume(volumes[0], companions), skipped)
    if not planes:
        raise _nothing_to_read(files)
    return ImageFiles(slices, None, len(files) - len(planes), simulated)


def _dicom_contents(files: Mapping[str, bytes]) -> Iterator[tuple[int, bytes]]:
    """Yield each DICOM file with its number in the order of names, from 1."""
    for number, name in enumerate(sorted(files), start=1):
        content = files[name]
        if dicom_reader.is_dicom(content) and PurePosixPath(name).name.upper() != "DICOMDIR":
            yield number, content
            continue
        suffix = PurePosixPath(name).suffix.lower()
        if suffix in DICOM_SUFFIXES or not (content or suffix):
            raise _unreadable(number, len(files))  # left out, the anatomy would be cut short


def _read_planes(
    contents: Iterator[tuple[int, bytes]], count: int
) -> tuple[list[tuple[Slice, ...]], bool]:
    """Return the planes of each file that has any, and whether a phantom wrote one of them."""
    series: dict[str, int] = {}
    planes, simulated = [], False
    for number, content in contents:
        try:
            dataset = dicom_reader.read_dataset(content)
            frames = dicom_reader.read_slices(dataset, series)
        except Exception:  # whatever breaks in a broken file; its message may quote identifiers
            raise _unreadable(number, count) from None
        if frames:
            planes.append(frames)
            simulated |= dataset.get("SeriesDescription", "") == dicom_writer.SIMULATED
    return planes, simulated


def _nothing_to_read(files: Mapping[str, bytes]) -> BadInput:
    foreign = sorted({end for end in FOREIGN_SUFFIXES for name in files if _ends(name, end)})
    found = f", among them {', '.join(foreign)}" if foreign else ""
    return BadInput(
        f"{len(files)} files{found}, none with an image plane",
        "DICOM images are grey, with position, orientation and pixel spacing of each plane;"
        " or there is one .nii, .nii.gz, .nrrd, .nhdr, .mha or .mhd file",
        "name the folder that holds the image series, or convert it to NIfTI",
    )


def _ends(name: str, suffix: str) -> bool:
    return name.lower().endswith(suffix)


def _unreadable(number: int, count: int) -> BadInput:
    return BadInput(
        f"file {number} of {count} (in the order of their names) is cut off or damaged",
        "every image file is whole",
        "export or copy it again",
    )
