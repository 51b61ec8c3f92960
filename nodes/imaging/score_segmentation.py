"""How well a segmentation agrees with the truth."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, UInt8

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, spacing_mm, voxel_volume_mm3
from nodes.geometry.masks import bounding_box, depth_mm

if TYPE_CHECKING:
    import pandas

ML_IN_MM3 = 1000.0
REST = "body"
LUNGS = ("left_lung", "right_lung", "lungs")
COLUMNS = (
    "label",
    "dice",
    "volume_ml",
    "truth_volume_ml",
    "volume_error_percent",
    "mean_surface_mm",
    "surface_95_mm",
)

Mask = Bool[np.ndarray, "i j k"]


def score_segmentation(label_map: LabelMap, truth: LabelMap) -> "pandas.DataFrame":
    """Score each label that both maps know, by Dice's 2|A and B| / (|A| + |B|) [Dice1945], by its
    volume, and by the distance of the two surfaces.

    "body" is, in both maps, all that is inside the skin and is none of the other labels that both
    know: where one map tells apart an effusion or an airway and the other does not, those count
    as body. "lungs" are both lungs together.

    Parameters
    ----------
    label_map : the segmentation.
    truth : the truth, on the same grid.

    Returns
    -------
    One row a common label: `label`, `dice` (1 where both are empty), `volume_ml`,
    `truth_volume_ml`, `volume_error_percent` of the truth, and the mean and the 95th percentile
    of the distance from each surface to the other, `mean_surface_mm` and `surface_95_mm`, between
    voxel centres; not a number where a label is empty.

    Raises
    ------
    BadInput where the grids differ or no name is common.
    """
    import pandas

    _refuse_other_grid(label_map, truth)
    common = [name for name in label_map.names if name in truth.names]
    lungs = _knows_lungs(label_map) and _knows_lungs(truth)
    if not common and not lungs:
        raise BadInput(
            f"labels {', '.join(label_map.names)} against {', '.join(truth.names)}",
            "both maps have at least one label name in common",
            "rename the labels of one of them",
        )
    found, true = (_common_labels(one, common, lungs) for one in (label_map, truth))
    pairs = {name: (found == n, true == n) for n, name in enumerate(common, start=1)}
    if lungs and "lungs" not in pairs:
        pairs["lungs"] = (_lungs(label_map), _lungs(truth))
    rows = [(name, *_score(*pair, truth.patient_from_index)) for name, pair in pairs.items()]
    return pandas.DataFrame(rows, columns=list(COLUMNS))


def _knows_lungs(label_map: LabelMap) -> bool:
    return any(name in label_map.names for name in LUNGS)


def _lungs(label_map: LabelMap) -> Mask:
    return np.isin(
        label_map.voxels, [n for n, name in enumerate(label_map.names, start=1) if name in LUNGS]
    )


def _refuse_other_grid(label_map: LabelMap, truth: LabelMap) -> None:
    same_place = np.allclose(label_map.patient_from_index, truth.patient_from_index, atol=1e-3)
    if label_map.voxels.shape != truth.voxels.shape or not same_place:
        raise BadInput(
            f"grids of {label_map.voxels.shape} and {truth.voxels.shape} voxels",
            "segmentation and truth lie on one grid",
            "bring one of them to the grid of the other",
        )


def _common_labels(
    label_map: LabelMap, common: list[str], lungs: bool
) -> UInt8[np.ndarray, "i j k"]:
    """Renumber to the common names; a label of one's own becomes the rest, where that exists.

    A lung that only one map names, while both know lungs, is no rest: it is scored as "lungs".
    """
    rest = common.index(REST) + 1 if REST in common else 0
    numbers = [0]
    for name in label_map.names:
        own = 0 if lungs and name in LUNGS else rest
        numbers.append(common.index(name) + 1 if name in common else own)
    return np.array(numbers, np.uint8)[label_map.voxels]


def _score(
    found: Mask, true: Mask, patient_from_index: Float[np.ndarray, "4 4"]
) -> tuple[float, float, float, float, float, float]:
    voxel_ml = voxel_volume_mm3(patient_from_index) / ML_IN_MM3
    sizes = int(np.count_nonzero(found)), int(np.count_nonzero(true))
    both = int(np.count_nonzero(found & true))
    dice = 2 * both / sum(sizes) if sum(sizes) else 1.0
    error = 100 * (sizes[0] / sizes[1] - 1) if sizes[1] else float("nan")
    mean, high = float("nan"), float("nan")
    if all(sizes):
        apart = _surface_distances(found, true, spacing_mm(patient_from_index))
        mean, high = float(apart.mean()), float(np.percentile(apart, 95))
    return dice, sizes[0] * voxel_ml, sizes[1] * voxel_ml, error, mean, high


def _surface_distances(
    found: Mask, true: Mask, spacing: Float[np.ndarray, "3"]
) -> Float[np.ndarray, " n"]:
    """Return the distance from each border voxel of either mask to the other's border, mm."""
    box = bounding_box(found | true, 1)
    one, other = (_border(mask[box]) for mask in (found, true))
    pairs = ((one, other), (other, one))
    return np.concatenate([-depth_mm(to, spacing)[start] for start, to in pairs]).astype(float)


def _border(mask: Mask) -> Mask:
    """Return the voxels of the mask that share a face with one outside or with the image's edge."""
    from scipy import ndimage

    return mask & ~ndimage.binary_erosion(mask)
