"""Stacks of planes that lean (gantry tilt) or lie unevenly, brought onto a straight even grid.

With a tilted gantry the table still moves along itself: each plane is shifted within itself
against the one below. Read as if they lay straight, such stacks are sheared, and larger by the
inverse cosine of the tilt. Shifting the planes back by exactly their own offsets undoes both.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Shaped

# Parts of a pixel below which a shift counts as whole, so that whole shifts copy values exactly.
_DECIMALS = 6


@dataclass(frozen=True)
class PlaneStack:
    """Parallel planes, sorted along their normal.

    Parameters
    ----------
    voxels : (i, j, k) values, plane k.
    axes : (3, 3) columns: steps along i and j in patient LPS mm, and the unit normal.
    positions : (k, 3) first pixel of each plane, patient LPS mm.
    """

    voxels: Shaped[np.ndarray, "i j k"]
    axes: Float[np.ndarray, "3 3"]
    positions: Float[np.ndarray, "k 3"]

    def heights(self) -> Float[np.ndarray, "k"]:
        """Return the places of the planes along the normal, mm."""
        return self.positions @ self.axes[:, 2]

    def tilt_deg(self) -> float:
        """Return the angle between the normal and the way from the first plane to the last."""
        course = self.positions[-1] - self.positions[0]
        along = course @ self.axes[:, 2]
        across = np.linalg.norm(course - along * self.axes[:, 2])
        return float(np.rad2deg(np.arctan2(across, along)))

    def largest_sideways_shift_mm(self) -> float:
        """Return how far a plane lies from the straight line from the first to the last, mm."""
        heights = self.heights()
        share = (heights - heights[0]) / (heights[-1] - heights[0])
        line = self.positions[0] + share[:, None] * (self.positions[-1] - self.positions[0])
        return float(np.linalg.norm(self.positions - line, axis=1).max())

    def patient_from_index(self) -> Float[np.ndarray, "4 4"]:
        """Return the grid of an even stack; its third axis leans as the stack does."""
        matrix = np.eye(4)
        matrix[:3, :2] = self.axes[:, :2]
        matrix[:3, 2] = (self.positions[-1] - self.positions[0]) / (len(self.positions) - 1)
        matrix[:3, 3] = self.positions[0]
        return matrix


def straighten(stack: PlaneStack, outside: float) -> PlaneStack:
    """Shift each plane within itself so that all lie straight above each other.

    The grid grows along i and j until it holds every scanned pixel; what was not scanned gets the
    value `outside`. Values between pixels are interpolated linearly.
    """
    from scipy.ndimage import affine_transform

    spacing = np.linalg.norm(stack.axes[:, :2], axis=0)
    offsets = (stack.positions - stack.positions[0]) @ (stack.axes[:, :2] / spacing**2)
    shifts = np.round(offsets, _DECIMALS)
    lowest, highest = np.floor(shifts.min(axis=0)), np.ceil(shifts.max(axis=0))
    size = stack.voxels.shape[:2] + (highest - lowest).astype(int)
    voxels = np.empty((*size, len(shifts)), stack.voxels.dtype)
    for k, shift in enumerate(shifts):
        voxels[:, :, k] = affine_transform(
            stack.voxels[:, :, k], np.ones(2), lowest - shift, tuple(size), order=1, cval=outside
        )
    first = stack.positions[0] + stack.axes[:, :2] @ lowest
    heights = stack.heights()
    positions = first + np.outer(heights - heights[0], stack.axes[:, 2])
    return replace(stack, voxels=voxels, positions=positions)


def even_out(stack: PlaneStack, tolerance_mm: float) -> PlaneStack:
    """Interpolate linearly between neighbouring planes to even steps.

    They are as the smallest distance between planes, but for the tolerance (else a rounded header
    would cost a plane), and not finer than the pixels are.
    """
    heights = stack.heights()
    finest = float(np.linalg.norm(stack.axes[:, :2], axis=0).min())
    step = max(float(np.diff(heights).min()), finest) + tolerance_mm
    count = int(np.ceil((heights[-1] - heights[0]) / step)) + 1
    wanted = np.linspace(heights[0], heights[-1], count)
    below = np.clip(np.searchsorted(heights, wanted, side="right") - 1, 0, len(heights) - 2)
    share = (wanted - heights[below]) / (heights[below + 1] - heights[below])
    voxels = np.empty((*stack.voxels.shape[:2], count), stack.voxels.dtype)
    for k, (low, part) in enumerate(zip(below, share, strict=True)):
        values = (1 - part) * stack.voxels[:, :, low] + part * stack.voxels[:, :, low + 1]
        voxels[:, :, k] = values if voxels.dtype.kind == "f" else np.rint(values)
    course = (stack.positions[-1] - stack.positions[0]) / (heights[-1] - heights[0])
    positions = stack.positions[0] + np.outer(wanted - heights[0], course)
    return replace(stack, voxels=voxels, positions=positions)
