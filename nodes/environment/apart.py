"""Walls between free labels that are two anatomical spaces, where their cells touch."""

import numpy as np
from jaxtyping import Bool, Float32

from nodes.environment.free_parts import boundary_of
from nodes.environment.parameters import BuildOccupancyGridParameters
from nodes.environment.resampling import resample_mask
from nodes.geometry.grids import LabelMap
from nodes.geometry.masks import bounding_box

Cells = Bool[np.ndarray, "a b c"]
Share = Float32[np.ndarray, "a b c"]

EVEN = 1e-5  # shares that differ by less are the same but for rounding


def free_pairs(parameters: BuildOccupancyGridParameters) -> list[tuple[str, str]]:
    """Return the pairs that never communicate and of which both labels are free."""
    return [pair for pair in parameters.apart if set(pair) <= set(parameters.free_labels)]


def wall_between(
    pair: tuple[str, str],
    label_map: LabelMap,
    mask: Bool[np.ndarray, "i j k"],
    free: Cells,
    voxel_size_mm: float,
) -> Cells:
    """Return the free cells that keep two labels from being connected over faces.

    A cell belongs to the label that has more of it. The wall are all cells next to one of the other
    label's, on both sides, and those of which both have as much, so that neither label is favoured.

    Parameters
    ----------
    pair : names of the two labels.
    label_map : anatomy.
    mask : all free labels, whose bounding box is that of the cells.
    free : cells that are free.
    voxel_size_mm : edge of the cells.
    """
    one, other = (_share(name, label_map, mask, voxel_size_mm) for name in pair)
    of_one, of_other = free & (one > other + EVEN), free & (other > one + EVEN)
    even = free & (abs(one - other) <= EVEN) & (one > EVEN)
    touch_one, touch_other = (boundary_of(cells, "faces") for cells in (of_one, of_other))
    return even | (of_one & touch_other) | (of_other & touch_one)


def _share(
    name: str, label_map: LabelMap, mask: Bool[np.ndarray, "i j k"], voxel_size_mm: float
) -> Share:
    return resample_mask(
        label_map.mask(name), label_map.patient_from_index, voxel_size_mm, bounding_box(mask)
    )[0]
