"""Where sites lie in an anatomy."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap, spacing_mm
from nodes.geometry.masks import bounding_box
from nodes.geometry.sites import Sites
from nodes.imaging.parameters import CheckSitesParameters

if TYPE_CHECKING:
    import pandas

OUTSIDE, BACKGROUND = "outside", "background"


def check_sites(
    label_map: LabelMap, sites: Sites, parameters: CheckSitesParameters
) -> "pandas.DataFrame":
    """Tell for each site which label it lies in and how far it is from each.

    Parameters
    ----------
    label_map : anatomy; its axes are at right angles to each other.
    sites : poses and points, any number.
    parameters : what counts as being at a label.

    Returns
    -------
    One row a site, poses first: `site`; `kind`, "pose" or "point"; `x_mm`, `y_mm`, `z_mm` in
    patient LPS; `inside`, the label of the voxel that holds it, "background" where that has none,
    "outside" beyond the grid; `at`, all labels within the tolerance, the nearest first; and for
    each label `to_<label>_mm`, how far it is to the nearest point of the label's voxels, 0 inside
    (NaN for a label without voxels).
    """
    import pandas

    places = sites.places_patient_mm
    index = transform_points(np.linalg.inv(label_map.patient_from_index), places)
    distances = np.array([_distances(label_map, name, index) for name in label_map.names])
    distances = distances.reshape(len(label_map.names), len(index))
    table = {
        "site": list(sites.names),
        "kind": ["pose"] * len(sites.pose_names) + ["point"] * len(sites.point_names),
        "x_mm": places[:, 0], "y_mm": places[:, 1], "z_mm": places[:, 2],
        "inside": [_label_at(label_map, place) for place in index],
        "at": [_labels_near(label_map.names, row, parameters.tolerance_mm) for row in distances.T],
    }  # fmt: skip
    table |= {f"to_{name}_mm": row for name, row in zip(label_map.names, distances, strict=True)}
    return pandas.DataFrame(table).astype(dict.fromkeys(("site", "kind", "inside", "at"), "str"))


def _label_at(label_map: LabelMap, index: Float[np.ndarray, "3"]) -> str:
    voxel = np.floor(index + 0.5).astype(int)
    if (voxel < 0).any() or (voxel >= label_map.voxels.shape).any():
        return OUTSIDE
    label = int(label_map.voxels[tuple(voxel)])
    return label_map.names[label - 1] if label else BACKGROUND


def _labels_near(
    names: tuple[str, ...], distances_mm: Float[np.ndarray, " n"], tolerance_mm: float
) -> str:
    nearest = np.argsort(distances_mm, kind="stable")
    return ", ".join(names[n] for n in nearest if distances_mm[n] <= tolerance_mm)


def _distances(
    label_map: LabelMap, name: str, index: Float[np.ndarray, "sites 3"]
) -> Float[np.ndarray, " sites"]:
    """Return the distance in mm of each place to the nearest point of any voxel of a label."""
    from scipy import ndimage

    mask = label_map.mask(name)
    box = bounding_box(mask)
    mask = mask[box]
    if not mask.any():
        return np.full(len(index), np.nan)
    surface = np.argwhere(mask & ~ndimage.binary_erosion(mask))
    places = index - [side.start for side in box]
    step = spacing_mm(label_map.patient_from_index)
    return np.array([0.0 if _holds(mask, place) else _nearest(surface, place, step)
                     for place in places])  # fmt: skip


def _holds(mask: Bool[np.ndarray, "i j k"], place: Float[np.ndarray, "3"]) -> bool:
    voxel = np.floor(place + 0.5).astype(int)
    inside = (voxel >= 0).all() and (voxel < mask.shape).all()
    return bool(inside and mask[tuple(voxel)])


def _nearest(
    voxels: Int[np.ndarray, "n 3"], place: Float[np.ndarray, "3"], step_mm: Float[np.ndarray, "3"]
) -> float:
    """A voxel reaches half a step from its centre along each axis."""
    beyond_mm = np.maximum(abs(voxels - place) - 0.5, 0) * step_mm
    return float(np.sqrt((beyond_mm**2).sum(axis=1).min()))
