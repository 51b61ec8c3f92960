"""How near the introducer sheaths come to bone outside of the cavity."""

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.planning.checking_boxes import Boxes, make_boxes
from nodes.planning.checking_clearances import Clearances, measure_clearances
from nodes.planning.checking_shapes import Course
from nodes.planning.parameters import CheckCrispPlansParameters

AROUND_MM = 20.0  # beyond the sheaths' ends nothing is looked at: it is this far at least


def find_bone(
    label_map: LabelMap,
    entries_patient_mm: Float[np.ndarray, "needle 3"],
    parameters: CheckCrispPlansParameters,
) -> Boxes:
    """Return the boxes of what sheaths avoid, as far as they may come near.

    Beyond the label map nothing is known, and nothing is said to be in the way.
    """
    for name in parameters.sheath_avoids:
        if name not in label_map.names:
            raise BadInput(
                f"sheath_avoids: {name}",
                f"the label map has the labels {', '.join(label_map.names)}",
                "set sheath_avoids to some of them, or to none",
            )
    numbers = [label_map.names.index(name) + 1 for name in parameters.sheath_avoids]
    axes = np.linalg.inv(label_map.patient_from_index)
    at = entries_patient_mm @ axes[:3, :3].T + axes[:3, 3]
    around = (parameters.outside_mm + AROUND_MM) * np.linalg.norm(axes[:3, :3], axis=1)
    shape = label_map.voxels.shape
    low = np.clip(np.floor(at.min(axis=0) - around).astype(int), 0, shape)
    high = np.clip(np.ceil(at.max(axis=0) + around).astype(int) + 1, 0, shape)
    box = tuple(slice(start, end) for start, end in zip(low, high, strict=True))
    matrix = np.array(label_map.patient_from_index)
    matrix[:3, 3] += matrix[:3, :3] @ low
    return make_boxes(np.isin(label_map.voxels[box], numbers), matrix, outside=False)


def measure_sheath(
    entry_patient_mm: Float[np.ndarray, "3"],
    tangents: Float[np.ndarray, "c 3"],
    radius_mm: float,
    bone: Boxes,
    parameters: CheckCrispPlansParameters,
) -> Clearances:
    """Return at most the clearances of a sheath, as thick as its needle, that goes straight back
    from an entry point along a motion."""
    back = parameters.model_copy(update={"sheath_mm": 0.0})
    count = int(np.ceil(parameters.outside_mm / parameters.sample_spacing_mm)) + 1
    arcs = np.linspace(0.0, parameters.outside_mm, max(count, 2))
    course = Course(
        np.tile(arcs, (len(tangents), 1)),
        entry_patient_mm - arcs[:, None] * tangents[:, None],
        np.repeat(-tangents[:, None], len(arcs), axis=1),
    )
    return measure_clearances(course, radius_mm, bone, back)
