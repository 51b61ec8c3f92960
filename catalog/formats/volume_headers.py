"""Where a volume file says that it lies in the patient, and when that cannot be trusted.

ITK takes one of the places that a NIfTI header may give, takes spacing and direction from two
different parts of it, and calls axes of unknown meaning patient axes, all without a word.
"""

import struct
import zlib
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput

if TYPE_CHECKING:
    import SimpleITK

# NIfTI xyzt_units: metre, millimetre, micrometre in mm; files without a unit mean mm.
_NIFTI_UNITS_MM = {1: 1000.0, 2: 1.0, 3: 0.001}
_NIFTI_HEADER = 348  # bytes, and the number that it begins with; ITK reads version 1 only
_RAS_FROM_LPS = np.diag([-1.0, -1.0, 1.0, 1.0])


def check_place(image: "SimpleITK.Image", header: bytes) -> tuple[str, ...]:
    """Return notices about the place of a volume, as ITK read it.

    Parameters
    ----------
    header : the volume file's bytes, of which only the header is read.

    Raises
    ------
    BadInput where the header does not place the volume in the patient, or contradicts itself.
    """
    if image.HasMetaDataKey("sform_code"):
        return _check_nifti(image, _qform(image, _handedness(header)))
    text = header[:16_384].decode("latin-1")
    if image.GetMetaData("ITK_InputFilterName") == "NrrdImageIO":
        return _check_nrrd(image, text.partition("\n\n")[0].replace("\r", ""))
    known = any(word in text for word in ("TransformMatrix", "Rotation", "Orientation ="))
    return () if known else ("the header gives no axes: left, posterior, superior are assumed",)


def _check_nifti(image: "SimpleITK.Image", qform: Float[np.ndarray, "4 4"]) -> tuple[str, ...]:
    slope, intercept = (float(image.GetMetaData(f"scl_{part}")) for part in ("slope", "inter"))
    if slope == 0 and intercept != 0:  # by the standard it does not count, yet ITK adds it
        raise BadInput(
            f"the header has an intercept of {intercept:g} and a slope of 0",
            "values are scaled by both or by none",
            "save the volume again without scaling",
        )
    forms = {}
    if int(image.GetMetaData("sform_code")) > 0:
        forms["sform"] = _sform(image)
    if int(image.GetMetaData("qform_code")) > 0:
        forms["qform"] = qform
    if not forms:
        raise _no_place("the header has neither sform nor qform")
    read = _RAS_FROM_LPS @ patient_from_index(image)
    half_voxel = np.linalg.norm(read[:3, :3], axis=0).min() / 2
    apart = {name: _farthest_corner(form, read, image.GetSize()) for name, form in forms.items()}
    used = min(apart, key=lambda name: apart[name])
    if apart[used] > half_voxel:
        raise BadInput(
            f"{used} and voxel size put corners of the volume {apart[used]:.1f} mm apart",
            "sform or qform agree with the voxel size, within half a voxel",
            "mend the header, or export the scan again",
        )
    distance = max(apart.values())
    if distance <= half_voxel:
        return ()
    return (
        f"the header places the volume twice, up to {distance:.1f} mm apart: its {used} was used",
    )


def _unit_mm(image: "SimpleITK.Image") -> float:
    return _NIFTI_UNITS_MM.get(int(image.GetMetaData("xyzt_units")) & 7, 1.0)


def _sform(image: "SimpleITK.Image") -> Float[np.ndarray, "4 4"]:
    rows = [image.GetMetaData(f"srow_{axis}").split() for axis in "xyz"]
    return np.diag([*[_unit_mm(image)] * 3, 1.0]) @ np.vstack(
        [np.array(rows, float), [0.0, 0.0, 0.0, 1.0]]
    )


def _qform(image: "SimpleITK.Image", hand: float) -> Float[np.ndarray, "4 4"]:
    """Return method 2 of the NIfTI-1 standard: rotation by a unit quaternion, and handedness."""
    from scipy.spatial.transform import Rotation

    def number(key: str) -> float:
        return float(image.GetMetaData(key))

    vector = np.array([number(f"quatern_{part}") for part in "bcd"])
    real = np.sqrt(max(1.0 - float(vector @ vector), 0.0))
    spacing = np.array([number(f"pixdim[{axis}]") for axis in (1, 2, 3)])
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat([*vector, real]).as_matrix() * spacing * [1, 1, hand]
    matrix[:3, 3] = [number(f"qoffset_{axis}") for axis in "xyz"]
    return np.diag([*[_unit_mm(image)] * 3, 1.0]) @ matrix


def _handedness(content: bytes) -> float:
    """Return -1 where a NIfTI file's qform is mirrored, else 1; ITK keeps pixdim[0] to itself."""
    packed = content[:2] == b"\x1f\x8b"
    head = zlib.decompressobj(wbits=31).decompress(content, _NIFTI_HEADER) if packed else content
    end = "<" if struct.unpack_from("<i", head)[0] == _NIFTI_HEADER else ">"
    return -1.0 if struct.unpack_from(f"{end}f", head, 76)[0] < 0 else 1.0


def _farthest_corner(
    one: Float[np.ndarray, "4 4"], other: Float[np.ndarray, "4 4"], size: tuple[int, ...]
) -> float:
    """Return how far two grids put the same corner of a volume apart, mm."""
    corners = np.array(np.meshgrid(*[[0, n - 1] for n in size], [1])).reshape(4, -1)
    return float(np.linalg.norm(((one - other) @ corners)[:3], axis=0).max())


def _check_nrrd(image: "SimpleITK.Image", header: str) -> tuple[str, ...]:
    space = "NRRD_space"
    if not image.HasMetaDataKey(space) or "left" not in image.GetMetaData(space):
        raise _no_place("the header names no anatomical space")
    units = [line for line in header.split("\n") if line.lower().startswith("space units:")]
    if units and set(units[0].partition(":")[2].replace('"', " ").split()) - {"mm"}:
        raise BadInput(
            "the header's space units are not mm",
            "distances are in mm",
            "save the volume again with mm, for instance in 3D Slicer",
        )
    return ()


def patient_from_index(image: "SimpleITK.Image") -> Float[np.ndarray, "4 4"]:
    """Return the grid of a volume, to patient LPS mm."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.reshape(image.GetDirection(), (3, 3)) * image.GetSpacing()
    matrix[:3, 3] = image.GetOrigin()
    return matrix


def _no_place(value: str) -> BadInput:
    return BadInput(
        value,
        "the header says where left, posterior and superior are, so that no side is mistaken",
        "open the volume in a viewer, make sure of its sides, and save it as NRRD or NIfTI there",
    )
