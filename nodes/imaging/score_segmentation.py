"""How well a segmentation agrees with the truth."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, UInt8

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, voxel_volume_mm3

if TYPE_CHECKING:
    import pandas

ML_IN_MM3 = 1000.0
REST = "body"


def score_segmentation(label_map: LabelMap, truth: LabelMap) -> "pandas.DataFrame":
    """Score each label that both maps know, by Dice's 2|A and B| / (|A| + |B|) [Dice1945].

    "body" is, in both maps, all that is inside the skin and is none of the other labels that both
    know: where one map tells apart an effusion or an airway and the other does not, those count
    as body.

    Parameters
    ----------
    label_map : the segmentation.
    truth : the truth, on the same grid.

    Returns
    -------
    One row a common label: `label`, `dice` (1 where both are empty), `volume_ml`,
    `truth_volume_ml`.

    Raises
    ------
    BadInput where the grids differ or no name is common.
    """
    import pandas

    _refuse_other_grid(label_map, truth)
    common = [name for name in label_map.names if name in truth.names]
    if not common:
        raise BadInput(
            f"labels {', '.join(label_map.names)} against {', '.join(truth.names)}",
            "both maps have at least one label name in common",
            "rename the labels of one of them",
        )
    found, true = _common_labels(label_map, common), _common_labels(truth, common)
    voxel_ml = voxel_volume_mm3(truth.patient_from_index) / ML_IN_MM3
    rows = [
        (name, *_score(found == number, true == number, voxel_ml))
        for number, name in enumerate(common, start=1)
    ]
    return pandas.DataFrame(rows, columns=["label", "dice", "volume_ml", "truth_volume_ml"])


def _refuse_other_grid(label_map: LabelMap, truth: LabelMap) -> None:
    same_place = np.allclose(label_map.patient_from_index, truth.patient_from_index, atol=1e-3)
    if label_map.voxels.shape != truth.voxels.shape or not same_place:
        raise BadInput(
            f"grids of {label_map.voxels.shape} and {truth.voxels.shape} voxels",
            "segmentation and truth lie on one grid",
            "bring one of them to the grid of the other",
        )


def _common_labels(label_map: LabelMap, common: list[str]) -> UInt8[np.ndarray, "i j k"]:
    """Renumber to the common names; a label of one's own becomes the rest, where that exists."""
    rest = common.index(REST) + 1 if REST in common else 0
    numbers = [common.index(name) + 1 if name in common else rest for name in label_map.names]
    return np.array([0, *numbers], np.uint8)[label_map.voxels]


def _score(
    found: Bool[np.ndarray, "i j k"], true: Bool[np.ndarray, "i j k"], voxel_ml: float
) -> tuple[float, float, float]:
    sizes = int(np.count_nonzero(found)), int(np.count_nonzero(true))
    both = int(np.count_nonzero(found & true))
    dice = 2 * both / sum(sizes) if sum(sizes) else 1.0
    return dice, sizes[0] * voxel_ml, sizes[1] * voxel_ml
