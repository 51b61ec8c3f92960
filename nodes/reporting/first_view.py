"""Where the slice viewer begins: at the slices that show most of what is labelled."""

import numpy as np
from jaxtyping import Int, UInt8


def choose_first_slices(labels: UInt8[np.ndarray, "i j k"], shown: tuple[int, ...]) -> list[int]:
    """Return for each axis the slice that shows most of the labels, each by its own measure.

    A slice earns for every label the label's area there over its largest area in any slice of that
    axis: a small nodule counts as much as a lung. Of equal slices the middle one is taken.

    Parameters
    ----------
    labels : (i, j, k) label numbers.
    shown : the numbers that count; where none of them is anywhere, every label does, and where
        there is no label, the middle is returned.
    """
    numbers = np.unique(labels)
    counted = np.intersect1d(numbers, shown)
    wanted = counted if len(counted) else numbers[numbers > 0]
    return [best_slice(areas_along(labels, axis)[:, wanted]) for axis in range(3)]


def areas_along(labels: UInt8[np.ndarray, "i j k"], axis: int) -> Int[np.ndarray, "slices 256"]:
    """Return how many voxels of each label lie in each slice of one axis."""
    slices = np.moveaxis(labels, axis, 0).reshape(labels.shape[axis], -1)
    return np.array([np.bincount(plane, minlength=256) for plane in slices])


def best_slice(areas: Int[np.ndarray, "slices labels"]) -> int:
    """Return the middle one of the slices that earn most."""
    earned = (areas / areas.max(axis=0, initial=1)).sum(axis=1)
    best = np.flatnonzero(earned >= earned.max() - 1e-9)
    return int(best[len(best) // 2])
