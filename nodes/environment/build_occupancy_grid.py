"""Where the robot may move: free cells, and the obstacle cells that bound them."""

import numpy as np
from jaxtyping import Bool, Float

from nodes.environment.parameters import BuildOccupancyGridParameters
from nodes.environment.resampling import resample_mask
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, voxel_volume_mm3
from nodes.geometry.masks import connected_parts
from nodes.geometry.origin import Origin

NAMES = ("free", "boundary")
FREE, BOUNDARY = 1, 2
ML_IN_MM3 = 1000.0


def build_occupancy_grid(label_map: LabelMap, parameters: BuildOccupancyGridParameters) -> LabelMap:
    """Build S_free and S_bound of [Kuntz2017] Sec. IV-A on cubic cells; all else is S_obs.

    S_free is the largest part of the label, connected over faces: a robot cannot pass through an
    edge or a corner. A cell is free where at least half of it is inside the label. S_bound are the
    obstacle cells that touch a free one over a face (6 neighbours; the paper says "adjacent").
    The grid reaches two cells beyond the label, so S_bound is closed; beyond the grid all is
    obstacle.

    Parameters
    ----------
    label_map : anatomy.
    parameters : the free label, the size of the cells.

    Returns
    -------
    "free", "boundary", and 0 for all other obstacle cells.

    Raises
    ------
    BadInput where the label is unknown, or too small for one cell.
    """
    name = parameters.free_label
    mask = _mask(label_map, name)
    share, patient_from_index = resample_mask(
        mask, label_map.patient_from_index, parameters.voxel_size_mm
    )
    free, dropped_ml = _largest_part(share >= 0.5, patient_from_index, name)
    labels = np.zeros(free.shape, np.uint8)
    labels[_face_neighbours(free) & ~free] = BOUNDARY
    labels[free] = FREE
    origin = label_map.origin.with_notice(*_notices(mask, name, dropped_ml))
    return LabelMap(labels, patient_from_index, NAMES, _from(origin, name))


def _mask(label_map: LabelMap, name: str) -> Bool[np.ndarray, "i j k"]:
    if name not in label_map.names:
        raise BadInput(
            f"free_label: {name}",
            f"the label map has the labels {', '.join(label_map.names)}",
            "set free_label to one of them",
        )
    mask = label_map.mask(name)
    if not mask.any():
        raise _too_small(name)
    return mask


def _largest_part(
    free: Bool[np.ndarray, "a b c"], patient_from_index: Float[np.ndarray, "4 4"], name: str
) -> tuple[Bool[np.ndarray, "a b c"], float]:
    """Return the largest part, and the volume of the others in ml."""
    parts, sizes = connected_parts(free)
    if not len(sizes):
        raise _too_small(name)
    dropped = int(sizes.sum() - sizes.max())
    return parts == sizes.argmax() + 1, dropped * voxel_volume_mm3(patient_from_index) / ML_IN_MM3


def _face_neighbours(mask: Bool[np.ndarray, "a b c"]) -> Bool[np.ndarray, "a b c"]:
    """Return the cells that share a face with a cell of the mask."""
    touched = np.zeros_like(mask)
    for axis in range(3):
        cells, source = np.moveaxis(touched, axis, 0), np.moveaxis(mask, axis, 0)
        cells[1:] |= source[:-1]
        cells[:-1] |= source[1:]
    return touched


def _notices(mask: Bool[np.ndarray, "i j k"], name: str, dropped_ml: float) -> list[str]:
    notices = []
    if dropped_ml > 0:
        notices.append(f"parts of {name} that are not joined to the largest one were dropped from"
                       f" the free space ({dropped_ml:.3g} ml)")  # fmt: skip
    sides = [np.moveaxis(mask, axis, 0)[end] for axis in range(3) for end in (0, -1)]
    if any(side.any() for side in sides):
        notices.append(f"{name} reaches the edge of the image: the free space is closed there")
    return notices


def _from(origin: Origin, name: str) -> Origin:
    return Origin(f"{name} of {origin.source}", origin.simulated, origin.notices)


def _too_small(name: str) -> BadInput:
    return BadInput(
        f"label {name} holds no free cell",
        "the free label fills at least half of one cell",
        "choose another free_label, a smaller voxel_size_mm, or correct the segmentation",
    )
