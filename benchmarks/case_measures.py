"""What is measured on a public case once it has run."""

from typing import Any

import numpy as np

from nodes.geometry.grids import LabelMap, voxel_volume_mm3
from nodes.geometry.masks import connected_parts
from pipelines.opened_case import OpenedCase


def measure_chest(case: OpenedCase) -> dict[str, float]:
    """Volume and number of parts of each lung, and volume of the airway."""
    label_map = case.load("label_map")
    litre = voxel_volume_mm3(label_map.patient_from_index) / 1e6
    row: dict[str, float] = {}
    for name in ("left_lung", "right_lung", "airway"):
        _, sizes = connected_parts(label_map.mask(name))
        row |= {f"{name}_parts": len(sizes), f"{name}_l": float(sizes.sum() * litre)}
    return row | {"lungs_l": row["left_lung_l"] + row["right_lung_l"]}


def measure_collapse(case: OpenedCase) -> dict[str, float]:
    """Volumes of cavity and collapsed lung, together and before."""
    label_map, before = case.load("label_map"), case.load("scanned_label_map")
    litre = voxel_volume_mm3(label_map.patient_from_index) / 1e6
    cavity = np.count_nonzero(label_map.mask("pleural_cavity")) * litre
    _, sizes = connected_parts(label_map.mask("pleural_cavity"))
    old = np.count_nonzero(before.mask("right_lung")) * litre
    return {"cavity_l": cavity, "old_lung_l": old, "cavity_parts": len(sizes)}


def measure_head(case: OpenedCase) -> dict[str, float]:
    """Volume and parts of the brain, how alike its halves are, and where the skull is open."""
    label_map = case.load("label_map")
    litre = voxel_volume_mm3(label_map.patient_from_index) / 1e6
    halves = [label_map.mask("left_brain"), label_map.mask("right_brain")]
    brain = halves[0] | halves[1] | label_map.mask("ventricles")
    _, sizes = connected_parts(brain)
    left, right = (np.count_nonzero(half) * litre for half in halves)
    return {
        "brain_l": float(sizes.sum() * litre),
        "brain_parts": len(sizes),
        "halves_differ_percent": float(200 * abs(left - right) / (left + right)),
        "skull_open_share_of_height": lowest_way_out(label_map, brain),
    }


def lowest_way_out(label_map: LabelMap, brain: np.ndarray) -> float:
    """Return up to which share of the brain's height one can leave it without crossing the skull.

    From below: planes are opened one after the other until what is not skull joins the brain to
    the air around the head; 0 is the brain's lowest plane, 1 its highest.
    """
    axis = int(np.argmax(abs(label_map.patient_from_index[2, :3])))
    up = label_map.patient_from_index[2, axis] > 0
    voxels, brain = (np.moveaxis(a, axis, 0)[:: 1 if up else -1] for a in (label_map.voxels, brain))
    skull = voxels == label_map.names.index("skull") + 1
    planes = np.flatnonzero(brain.any(axis=(1, 2)))
    low, high = int(planes[0]), int(planes[-1])
    first, last = low, high
    while first < last:  # the highest plane from which upwards brain and outside are apart
        middle = (first + last) // 2
        if leaks_above(voxels, skull, brain, middle):
            first = middle + 1
        else:
            last = middle
    return (first - low) / (high - low)


def leaks_above(voxels: np.ndarray, skull: np.ndarray, brain: np.ndarray, plane: int) -> bool:
    """Return whether brain and outside are joined by voxels that are no skull, above a plane."""
    parts, _ = connected_parts(~skull[plane:])
    inside = np.unique(parts[brain[plane:]])
    outside = np.unique(parts[voxels[plane:] == 0])
    return bool(np.intersect1d(inside[inside > 0], outside[outside > 0]).size)


def measure_sites(case: OpenedCase) -> dict[str, Any]:
    """Return where starts and targets lie."""
    table = case.load("site_table").set_index("site")
    return {
        "target_inside": str(table.inside["target"]),
        "start_to_airway_mm": float(table.to_airway_mm[table.kind == "pose"].max()),
        "lungs_l": float(case.load("label_table").set_index("label").volume_ml["pleura"] / 1e3),
    }


def measure_nothing(case: OpenedCase) -> dict[str, Any]:
    """Return nothing: the case is run for its time and memory."""
    return {}
