"""What SimpleITK reads and writes: volume files and compressed DICOM pixels.

ITK reads from disk only, so bytes go through a scratch folder; it gets no identifier to see.
"""

import gzip
import os
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Shaped

from nodes.errors import BadInput
from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin

if TYPE_CHECKING:
    import SimpleITK
    from pydicom import Dataset

VOLUME_SUFFIXES = (".nii", ".nii.gz", ".nrrd", ".nhdr", ".mha", ".mhd")
# Headers that keep their pixels in a file beside them, and the key that names it.
DETACHED = {".mhd": "elementdatafile", ".nhdr": "data file"}
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
    "PixelData",
)


def is_volume_name(name: str) -> bool:
    """Return whether the name's ending says that the file holds a volume."""
    return name.lower().endswith(VOLUME_SUFFIXES)


def companions(name: str, files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the volume file and the file with its pixels, if that is another one, by base names.

    A header must not name a file outside of the input: its content would go unnoticed when it
    changes.
    """
    path = PurePosixPath(name)
    found = {path.name: files[name]}
    key = DETACHED.get(path.suffix.lower())
    if key is None:
        return found
    data_name = _header_value(files[name], key)
    if data_name.upper() != "LOCAL" and data_name:
        beside = str(path.parent / data_name)
        if "/" in data_name or "\\" in data_name or beside not in files:
            raise BadInput(
                f"the {path.suffix} header names a data file that is not beside it",
                "header and data file lie in one folder",
                "name the folder that holds both as the input, or save the volume as .nrrd or .mha",
            )
        found[data_name] = files[beside]
    return found


def _header_value(header: bytes, key: str) -> str:
    for line in header.decode("latin-1").splitlines():
        word, _, value = line.replace(":", "=", 1).partition("=")
        if word.strip().lower() == key:
            return value.strip()
    return ""


def read_volume(name: str, contents: Mapping[str, bytes]) -> Volume:
    """Read the volume file `name`; its unit is not known here, so it counts as intensity."""
    import SimpleITK as sitk

    name = PurePosixPath(name).name
    try:
        with TemporaryDirectory() as scratch:
            for file_name, content in contents.items():
                (Path(scratch) / file_name).write_bytes(content)
            image = sitk.ReadImage(str(Path(scratch) / name))
        _refuse_short_nifti(image, contents[name])
    except (RuntimeError, EOFError, OSError, zlib.error):
        raise _unreadable_volume() from None
    if image.GetDimension() != 3 or image.GetNumberOfComponentsPerPixel() != 1:
        raise BadInput(
            f"{image.GetDimension()} dimensions, {image.GetNumberOfComponentsPerPixel()} values"
            " for each voxel",
            "a volume has 3 dimensions and one value for each voxel",
            "save one grey volume of it in a file of its own",
        )
    return Volume(
        voxels=_narrowed(sitk.GetArrayFromImage(image).transpose(2, 1, 0)),
        patient_from_index=_patient_from_index(image),
        unit="intensity",
        origin=Origin("volume file"),
    )


def _refuse_short_nifti(image: "SimpleITK.Image", content: bytes) -> None:
    """ITK fills what a cut-off NIfTI file lacks with zeros and says nothing."""
    if not image.HasMetaDataKey("vox_offset"):  # another format
        return
    content = gzip.decompress(content) if content[:2] == b"\x1f\x8b" else content
    pixels = image.GetNumberOfPixels() * image.GetNumberOfComponentsPerPixel()
    stored = pixels * int(image.GetMetaData("bitpix")) // 8
    if len(content) < float(image.GetMetaData("vox_offset")) + stored:
        raise EOFError


def _narrowed(voxels: Shaped[np.ndarray, "i j k"]) -> Shaped[np.ndarray, "i j k"]:
    """Return whole numbers that fit as int16 and everything else as float32."""
    if np.can_cast(voxels.dtype, np.int16):
        return voxels.astype(np.int16)
    limits = np.iinfo(np.int16)
    fits = limits.min <= voxels.min() and voxels.max() <= limits.max
    if fits and np.array_equal(voxels, np.rint(voxels)):
        return voxels.astype(np.int16)
    return voxels.astype(np.float32)


def _patient_from_index(image: "SimpleITK.Image") -> Float[np.ndarray, "4 4"]:
    matrix = np.eye(4)
    matrix[:3, :3] = np.reshape(image.GetDirection(), (3, 3)) * image.GetSpacing()
    matrix[:3, 3] = image.GetOrigin()
    return matrix


def write_volume(volume: Volume) -> bytes:
    """Write a volume as one MetaImage file."""
    import SimpleITK as sitk

    image = sitk.GetImageFromArray(volume.voxels.transpose(2, 1, 0))
    spacing = np.linalg.norm(volume.patient_from_index[:3, :3], axis=0)
    image.SetSpacing(spacing.tolist())
    image.SetDirection((volume.patient_from_index[:3, :3] / spacing).ravel().tolist())
    image.SetOrigin(volume.patient_from_index[:3, 3].tolist())
    with TemporaryDirectory() as scratch:
        path = Path(scratch) / "volume.mha"
        sitk.WriteImage(image, str(path))
        return path.read_bytes()


def unpack_pixels(dataset: "Dataset") -> Shaped[np.ndarray, "rows columns"]:
    """Return the stored values of a compressed DICOM image; raises where ITK cannot unpack it.

    The scratch file holds the pixels and how they are packed, and nothing else of the dataset.
    """
    import SimpleITK as sitk
    from pydicom import Dataset
    from pydicom.dataset import FileMetaDataset
    from pydicom.uid import SecondaryCaptureImageStorage

    bare = Dataset()
    for keyword in PIXEL_MODULE:
        bare[keyword] = dataset[keyword]
    bare.SOPClassUID, bare.SOPInstanceUID = SecondaryCaptureImageStorage, "2.25.1"
    bare.file_meta = FileMetaDataset()
    bare.file_meta.TransferSyntaxUID = dataset.file_meta.TransferSyntaxUID
    with TemporaryDirectory() as scratch:
        path = Path(scratch) / "plane.dcm"
        bare.save_as(path, enforce_file_format=True)
        with _decoder_heard(Path(scratch) / "words") as words:
            pixels = sitk.GetArrayFromImage(sitk.ReadImage(str(path)))[0]
        if b"Corrupt" in words():
            raise ValueError("the decoder found damaged pixels")
        return pixels


@contextmanager
def _decoder_heard(file: Path) -> Iterator[Callable[[], bytes]]:
    """Take what a C library writes on standard error; that is how it tells of damaged pixels."""
    kept = os.dup(2)
    with open(file, "wb") as stream:
        os.dup2(stream.fileno(), 2)
    try:
        yield file.read_bytes
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def _unreadable_volume() -> BadInput:
    return BadInput(
        "the volume file is cut off, damaged or of another kind than its name says",
        "the file is a whole NIfTI, NRRD or MetaImage file",
        "export or copy it again",
    )
