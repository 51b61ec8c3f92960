"""Body, bone and lungs in a chest CT by thresholds, connected parts and closing."""

import numpy as np
from jaxtyping import Bool

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume, spacing_mm, voxel_volume_mm3
from nodes.geometry.masks import (
    close_mask,
    connected_parts,
    enclosed_holes,
    open_planes,
    plane_holes,
)
from nodes.imaging.parameters import SegmentCtParameters

NAMES = ("body", "bone", "lungs")
ML_IN_MM3 = 1000.0


def segment_ct(ct: Volume, parameters: SegmentCtParameters) -> LabelMap:
    """Label what is inside the skin: "bone", "lungs", and all the rest as "body".

    A voxel has one label; bone and lungs win over body.

    Parameters
    ----------
    ct : chest CT in HU.
    parameters : thresholds, widths and sizes.

    Returns
    -------
    Label map on the grid of `ct`.

    Raises
    ------
    BadInput where values are not HU, or body, bone or lungs are not found.
    """
    if ct.unit != "HU":
        raise BadInput(
            f"a volume in {ct.unit}",
            "thresholds in HU need a CT volume in HU",
            "give the CT as its scanner wrote it; for an MRI use an MRI pipeline",
        )
    body = _segment_body(ct, parameters)
    lungs = _segment_lungs(ct, body, parameters)
    bone = _segment_bone(ct, body & ~lungs, parameters)
    labels = body.astype(np.uint8)
    labels[lungs] = NAMES.index("lungs") + 1
    labels[bone] = NAMES.index("bone") + 1
    origin = ct.origin.with_notice(
        "air in trachea and bronchi that joins the lungs is counted as lungs"
    )
    return LabelMap(labels, ct.patient_from_index, NAMES, origin)


def _segment_body(ct: Volume, parameters: SegmentCtParameters) -> Bool[np.ndarray, "i j k"]:
    """Return the largest part of tissue, without the table, and all that it surrounds.

    Holes are filled within axial planes: the lungs are open to no side there, while in three
    dimensions the trachea leads out at the top.
    """
    axis = _axial_axis(ct)
    tissue = ct.voxels >= parameters.body_threshold_hu
    tissue = open_planes(tissue, axis, parameters.table_opening_mm, _spacing(ct))
    largest = _largest_part(tissue)
    if largest is None:
        raise _not_found("body", parameters.body_threshold_hu, "at or above", 0.0)
    return largest | plane_holes(largest, axis)


def _axial_axis(ct: Volume) -> int:
    """Return the index axis that is closest to the patient's long axis."""
    return int(np.argmax(abs(ct.patient_from_index[2, :3]) / _spacing(ct)))


def _spacing(ct: Volume) -> np.ndarray:
    return spacing_mm(ct.patient_from_index)


def _largest_part(mask: Bool[np.ndarray, "i j k"]) -> Bool[np.ndarray, "i j k"] | None:
    parts, sizes = connected_parts(mask)
    return parts == sizes.argmax() + 1 if len(sizes) else None


def _segment_lungs(
    ct: Volume, body: Bool[np.ndarray, "i j k"], parameters: SegmentCtParameters
) -> Bool[np.ndarray, "i j k"]:
    """Return the air inside the body that is lung, its vessels filled."""
    from scipy import ndimage

    air = body & (ct.voxels < parameters.lung_threshold_hu)
    parts, sizes = connected_parts(air)
    volumes_ml = sizes * voxel_volume_mm3(ct.patient_from_index) / ML_IN_MM3
    large = np.flatnonzero(volumes_ml >= parameters.smallest_lung_ml) + 1
    means_hu = np.asarray(ndimage.mean(ct.voxels, parts, large)) if len(large) else np.empty(0)
    lungs = np.isin(parts, large[means_hu >= parameters.gas_mean_hu])
    if not lungs.any():
        raise _not_found(
            "lungs", parameters.lung_threshold_hu, "below", parameters.smallest_lung_ml
        )
    return close_mask(lungs, parameters.lung_closing_mm, _spacing(ct)) & body


def _segment_bone(
    ct: Volume, inside: Bool[np.ndarray, "i j k"], parameters: SegmentCtParameters
) -> Bool[np.ndarray, "i j k"]:
    """Return the bright parts that are large enough, with what they enclose."""
    bright = inside & (ct.voxels >= parameters.bone_threshold_hu)
    parts, sizes = connected_parts(bright)
    volumes_ml = sizes * voxel_volume_mm3(ct.patient_from_index) / ML_IN_MM3
    kept = np.concatenate([[False], volumes_ml >= parameters.smallest_bone_ml])
    bone = kept[parts]
    if not bone.any():
        raise _not_found(
            "bone", parameters.bone_threshold_hu, "at or above", parameters.smallest_bone_ml
        )
    bone = close_mask(bone, parameters.bone_closing_mm, _spacing(ct)) & inside
    return bone | enclosed_holes(bone)


def _not_found(name: str, threshold_hu: float, side: str, smallest_ml: float) -> BadInput:
    return BadInput(
        f"no {name} found in the CT",
        f"{name}: values {side} {threshold_hu:g} HU, in parts of {smallest_ml:g} ml or more",
        "check that the series shows the chest and is in HU, or change the parameters of"
        " segment_ct",
    )
