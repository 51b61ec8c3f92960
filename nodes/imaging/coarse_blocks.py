"""Blocks of voxels, for what is quicker or quieter to look for on a coarse grid."""

import numpy as np
from jaxtyping import Float, Shaped


def coarse_step(spacing_mm: Float[np.ndarray, "3"], coarse_mm: float) -> tuple[int, ...]:
    """Return how many voxels along each axis make a block of about this size."""
    return tuple(max(1, round(coarse_mm / float(step))) for step in spacing_mm)


def block_sums(
    values: Shaped[np.ndarray, "_ _ _"], step: tuple[int, ...]
) -> Shaped[np.ndarray, "_ _ _"]:
    """Return the sum over each block; the last block of an axis may be cut."""
    for axis, count in enumerate(step):
        if count > 1:
            values = np.add.reduceat(values, np.arange(0, values.shape[axis], count), axis=axis)
    return values


def refined(
    coarse: Shaped[np.ndarray, "_ _ _"], step: tuple[int, ...], shape: tuple[int, ...]
) -> Shaped[np.ndarray, "_ _ _"]:
    """Return an array of this shape in which every voxel has the value of its block."""
    for axis, count in enumerate(step):
        coarse = np.repeat(coarse, count, axis=axis)
    return np.ascontiguousarray(coarse[tuple(slice(n) for n in shape)])
