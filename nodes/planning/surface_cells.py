"""The cells of the free space's surface that a camera can see at all."""

import numpy as np
from jaxtyping import Bool, Int

from nodes.geometry.grids import LabelMap


def find_surface_cells(occupancy_grid: LabelMap) -> Int[np.ndarray, "n 3"]:
    """Return the boundary cells that share a face with a free one, in the grid's order."""
    free = occupancy_grid.mask("free")
    return np.argwhere(occupancy_grid.mask("boundary") & beside(free))


def beside(mask: Bool[np.ndarray, "i j k"]) -> Bool[np.ndarray, "i j k"]:
    """Return which cells have a face in common with a cell of the mask."""
    found = np.zeros_like(mask)
    for axis in range(3):
        to, of = np.moveaxis(found, axis, 0), np.moveaxis(mask, axis, 0)
        to[1:] |= of[:-1]
        to[:-1] |= of[1:]
    return found
