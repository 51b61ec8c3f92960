"""Exact distances to the faces of masks, computed by several threads."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from jaxtyping import Bool, Float, Float32

PARTS = 4  # pieces of work that threads share; the result is the same for any number


def distance_to_faces(
    mask: Bool[np.ndarray, "i j k"], spacing_mm: Float[np.ndarray, "3"]
) -> Float32[np.ndarray, "i j k"]:
    """Return each cell centre's distance to the nearest face between the mask and all else, mm.

    Inside of the mask that is the clearance to the nearest box outside, and the other way round.
    Beyond the grid nothing is mask. Infinite where the mask is empty.
    """
    from nodes.kernels.distance_transform import sweep

    squared = np.empty(mask.shape, np.float32)
    mask = np.ascontiguousarray(mask)
    with ThreadPoolExecutor(PARTS) as pool:
        for axis in (2, 1, 0):
            shape = (int(np.prod(mask.shape[:axis])), mask.shape[axis], -1)
            lines, cells = squared.reshape(shape), mask.reshape(shape)
            step, first = float(spacing_mm[axis]), axis == 2
            work = [
                pool.submit(sweep, lines, cells, step, first, part, PARTS) for part in range(PARTS)
            ]
            for done in work:
                done.result()
    return np.sqrt(squared, out=squared)
