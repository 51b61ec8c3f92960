"""Closing with wide balls, by distances, on cubic voxels."""

import numpy as np
from jaxtyping import Bool

from nodes.geometry.masks import grow_mask, shrink_mask

Mask = Bool[np.ndarray, "i j k"]


def close_widely(mask: Mask, radius_mm: float, voxel_size_mm: float) -> Mask:
    """Add what a ball of this radius cannot reach from outside of the mask.

    Two distance maps take the same time for any radius, unlike a moving ball. The image's edge
    does not hold the ball back.
    """
    spacing = np.full(3, voxel_size_mm)
    margin = int(np.ceil(radius_mm / voxel_size_mm)) + 1
    grown = grow_mask(np.pad(mask, margin), radius_mm, spacing)
    closed = shrink_mask(grown, radius_mm, spacing)
    return mask | closed[margin:-margin, margin:-margin, margin:-margin]
