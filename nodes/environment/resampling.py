"""Masks brought to another grid with cubic cells."""

import numpy as np
from jaxtyping import Bool, Float, Float32

from nodes.geometry.grids import spacing_mm
from nodes.geometry.masks import bounding_box

Affine = Float[np.ndarray, "4 4"]


def resample_mask(
    mask: Bool[np.ndarray, "i j k"],
    patient_from_index: Affine,
    voxel_size_mm: float,
    box: tuple[slice, slice, slice] | None = None,
) -> tuple[Float32[np.ndarray, "a b c"], Affine]:
    """Resample the part of a mask that is not empty to cubic cells along the same axes.

    Each cell's value is the mean of the mask over the cell's extent along each axis, or, where
    cells are smaller than voxels, linear between voxel centres. Outside of the image is nothing.

    Parameters
    ----------
    mask : not empty.
    patient_from_index : of the mask.
    voxel_size_mm : edge of the cells.
    box : part of the mask that is resampled; None for all that is not empty. Masks with one box
        come to the same cells.

    Returns
    -------
    share : share of each cell that is mask, 0 to 1; 0 in the outermost two layers of cells.
    patient_from_index : of the cells, patient LPS mm.
    """
    box = bounding_box(mask) if box is None else box
    spacing = spacing_mm(patient_from_index)
    share = mask[box].astype(np.float32)
    first_cells = []
    for axis, side in enumerate(box):
        weights, first = _weights(side, float(spacing[axis]), voxel_size_mm)
        share = np.moveaxis(np.tensordot(weights, share, axes=(1, axis)), 0, axis)
        first_cells.append(first)
    directions = patient_from_index[:3, :3] / spacing
    matrix = np.eye(4)
    matrix[:3, :3] = directions * voxel_size_mm
    matrix[:3, 3] = patient_from_index[:3, 3] + directions @ np.array(first_cells)
    return np.ascontiguousarray(share), matrix


def _weights(
    side: slice, step_mm: float, cell_mm: float
) -> tuple[Float32[np.ndarray, "cells voxels"], float]:
    """Return how voxels along one axis mix into cells, and the first cell's centre, mm from the
    image's first voxel centre.

    Cells as wide as voxels or wider take the share of them that each voxel covers, narrower ones
    the two voxels around their centre. Two cells on either side lie beyond the reach of all voxels.
    """
    low, high = (side.start - 0.5) * step_mm, (side.stop - 0.5) * step_mm
    count = int(np.ceil((high - low) / cell_mm)) + 4 + 2 * int(np.ceil(step_mm / cell_mm / 2))
    first = (low + high) / 2 - (count - 1) / 2 * cell_mm
    centres = first + cell_mm * np.arange(count)
    voxels = step_mm * np.arange(side.start, side.stop)
    apart = abs(centres[:, None] - voxels)
    if cell_mm >= step_mm:
        overlap = np.clip((cell_mm + step_mm) / 2 - apart, 0, step_mm) / cell_mm
    else:
        overlap = np.clip(1 - apart / step_mm, 0, 1)
    return overlap.astype(np.float32), float(first)
