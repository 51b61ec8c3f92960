"""Volume files, read and written by SimpleITK.

ITK reads from disk only, so bytes go through a scratch folder.
"""

import gzip
import zlib
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Shaped

from catalog.formats.native_words import native_words
from catalog.formats.volume_headers import check_place, patient_from_index
from nodes.errors import BadInput
from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin

if TYPE_CHECKING:
    import SimpleITK

VOLUME_SUFFIXES = (".nii", ".nii.gz", ".nrrd", ".nhdr", ".mha", ".mhd")
# Headers that keep their pixels in a file beside them, and the key that names it.
DETACHED = {".mhd": "elementdatafile", ".nhdr": "data file"}


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
    image = _read_image(name, contents)
    size = image.GetSize()
    if len(size) != 3 or image.GetNumberOfComponentsPerPixel() > 1:
        raise BadInput(
            f"a size of {' x '.join(map(str, size))}, with"
            f" {image.GetNumberOfComponentsPerPixel()} values for each voxel",
            "a volume has 3 dimensions and one value for each voxel",
            "save one grey volume of it in a file of its own",
        )
    return Volume(
        voxels=_narrowed(sitk.GetArrayFromImage(image).transpose(2, 1, 0)),
        patient_from_index=patient_from_index(image),
        unit="intensity",
        origin=Origin("volume file", notices=check_place(image, contents[name])),
    )


def _read_image(name: str, contents: Mapping[str, bytes]) -> "SimpleITK.Image":
    import SimpleITK as sitk

    try:
        with TemporaryDirectory() as scratch, native_words():
            for file_name, content in contents.items():
                (Path(scratch) / file_name).write_bytes(content)
            image = sitk.ReadImage(str(Path(scratch) / name))
        _refuse_short_nifti(image, contents[name])
        return image
    except RuntimeError as error:
        raise (_sheared() if "orthonormal" in str(error) else _unreadable_volume()) from None
    except (EOFError, OSError, zlib.error):
        raise _unreadable_volume() from None


def _refuse_short_nifti(image: "SimpleITK.Image", content: bytes) -> None:
    """ITK fills what a cut-off NIfTI file lacks with zeros and says nothing."""
    if not image.HasMetaDataKey("vox_offset"):  # another format
        return
    content = gzip.decompress(content) if content[:2] == b"\x1f\x8b" else content
    pixels = image.GetNumberOfPixels() * image.GetNumberOfComponentsPerPixel()
    stored = pixels * int(image.GetMetaData("bitpix")) // 8
    if len(content) < float(image.GetMetaData("vox_offset")) + stored:
        raise EOFError
    _refuse_nifti_nan(image, content, pixels)


def _refuse_nifti_nan(image: "SimpleITK.Image", content: bytes, count: int) -> None:
    """ITK turns what is no number into 0, which is soft tissue in a CT."""
    kind = {"16": "f4", "64": "f8"}.get(image.GetMetaData("datatype"))
    if kind is None:
        return
    end = "<" if content[:4] == (348).to_bytes(4, "little") else ">"
    start = int(float(image.GetMetaData("vox_offset")))
    values = np.frombuffer(content, f"{end}{kind}", count, start)
    strange = count - int(np.count_nonzero(np.isfinite(values)))
    if strange:
        raise BadInput(
            f"{strange} voxels are not a number or infinite",
            "every voxel must have a value",
            "replace them, for instance by -1024 HU outside the scan",
        )


def _narrowed(voxels: Shaped[np.ndarray, "i j k"]) -> Shaped[np.ndarray, "i j k"]:
    """Return whole numbers that fit as int16 and everything else as float32."""
    if np.can_cast(voxels.dtype, np.int16):
        return voxels.astype(np.int16)
    limits = np.iinfo(np.int16)
    fits = limits.min <= voxels.min() and voxels.max() <= limits.max
    if fits and np.array_equal(voxels, np.rint(voxels)):
        return voxels.astype(np.int16)
    return voxels.astype(np.float32)


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


def _unreadable_volume() -> BadInput:
    return BadInput(
        "the volume file is cut off, damaged or of another kind than its name says",
        "the file is a whole NIfTI, NRRD or MetaImage file",
        "export or copy it again",
    )


def _sheared() -> BadInput:
    return BadInput(
        "the axes in the volume file's header are missing or not at right angles",
        "rows, columns and planes of a NIfTI file are at right angles (ITK reads no others)",
        "resample the volume onto a straight grid, or hand in the DICOM files, which are"
        " straightened here",
    )
