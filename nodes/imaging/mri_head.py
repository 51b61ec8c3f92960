"""Where the head is in an MRI, how bright it is, and whether its skull was stripped off."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32

from nodes.errors import BadInput
from nodes.geometry.grids import Volume
from nodes.geometry.masks import (
    depth_mm,
    grow_mask,
    largest_part,
    parts_of_size,
    plane_holes,
    shrink_mask,
)
from nodes.imaging.brain_surface import Levels
from nodes.imaging.cubic_masks import close_widely
from nodes.imaging.parameters import SegmentMriParameters

ML_IN_MM3 = 1000.0
Mask = Bool[np.ndarray, "i j k"]
Affine = Float[np.ndarray, "4 4"]
Voxels = Float32[np.ndarray, "i j k"]


class Head(NamedTuple):
    """A head on a working grid.

    Parameters
    ----------
    mask : all inside the skin.
    middle : index along z of the middle of its upper part.
    centre_patient_mm : that middle, patient LPS mm.
    radius_mm : of a ball as large as its upper part.
    levels : intensities to go by.
    """

    mask: Mask
    middle: int
    centre_patient_mm: Float[np.ndarray, "3"]
    radius_mm: float
    levels: Levels


def find_range(mri: Volume, parameters: SegmentMriParameters) -> tuple[float, float]:
    """Return the robust lowest and highest level of an image.

    Raises
    ------
    BadInput where nearly all values are alike.
    """
    lowest, highest = np.percentile(mri.voxels, parameters.robust_percentiles)
    if not highest > lowest:
        raise BadInput(
            f"values from {mri.voxels.min():g} to {mri.voxels.max():g}, nearly all alike",
            "an MRI of a head shows tissue brighter than air",
            "check that the file holds the image and not a mask or a localiser",
        )
    return float(lowest), float(highest)


def find_head(
    voxels: Voxels,
    patient_from_index: Affine,
    levels: tuple[float, float],
    parameters: SegmentMriParameters,
) -> Head:
    """Find the largest bright part and the middle of its upper end, where the brain is.

    The neck is left out of the middle, so that its length does not matter.

    Parameters
    ----------
    voxels : (i, j, k) with edges of `skin_voxel_mm`, along the patient's axes.
    patient_from_index : (4, 4) voxel indices to patient LPS mm.
    levels : robust lowest and highest level.
    parameters : levels and sizes of a head.

    Raises
    ------
    BadInput where nothing is as large as a head.
    """
    from skimage import filters

    size = parameters.skin_voxel_mm
    lowest, highest = levels
    clipped = np.clip(voxels, lowest, highest)
    between = float(filters.threshold_otsu(clipped))  # [Otsu1979]
    background = lowest + parameters.background_share * (between - lowest)
    mask = _inside_skin(voxels > background, size, parameters)
    upper = _upper_part(mask, size, parameters.brain_height_mm)
    volume_mm3 = np.count_nonzero(upper) * size**3
    _refuse_small(volume_mm3 / ML_IN_MM3, parameters)
    centre = _centre_of_mass(np.where(upper, clipped - lowest, 0)) * size
    radius = float(np.cbrt(3 * volume_mm3 / (4 * np.pi)))
    near = _ball(voxels.shape, size, centre, radius)
    tissue = voxels[near & (voxels > background) & (voxels < highest)]
    found = Levels(lowest, background, float(np.median(tissue)), highest)
    middle = int(centre[2] / size)
    return Head(mask, middle, centre + patient_from_index[:3, 3], radius, found)


def _inside_skin(bright: Mask, voxel_size_mm: float, parameters: SegmentMriParameters) -> Mask:
    """Return the largest part of what is bright, with the dark bone and air that it surrounds.

    Filled first and opened then: a scalp as thin as ghosts and holders would not outlive the
    opening on its own.
    """
    spacing = np.full(3, voxel_size_mm)
    smallest = parameters.smallest_skin_part_ml * ML_IN_MM3 / voxel_size_mm**3
    filled = close_widely(
        parts_of_size(bright, smallest), parameters.skin_closing_mm, voxel_size_mm
    )
    for axis in (2, 0, 1):
        filled = filled | plane_holes(filled, axis)
    core = largest_part(shrink_mask(filled, parameters.skin_opening_mm, spacing))
    return filled & grow_mask(core, 1.5 * parameters.skin_opening_mm, spacing)


def _upper_part(mask: Mask, voxel_size_mm: float, height_mm: float) -> Mask:
    """Return what lies at most this far below the highest voxel."""
    heights = np.flatnonzero(mask.any(axis=(0, 1)))
    lowest = int(heights[-1] + 1 - height_mm / voxel_size_mm) if len(heights) else 0
    upper = mask.copy()
    upper[:, :, : max(lowest, 0)] = False
    return upper


def _refuse_small(volume_ml: float, parameters: SegmentMriParameters) -> None:
    if volume_ml < parameters.smallest_brain_ml:
        raise BadInput(
            f"no head found: the largest bright part has {volume_ml:.0f} ml",
            f"a head has {parameters.smallest_brain_ml:g} ml or more in its upper"
            f" {parameters.brain_height_mm:g} mm",
            "check that the series shows a whole head, and its spacing in mm",
        )


def _centre_of_mass(weights: Float[np.ndarray, "i j k"]) -> Float[np.ndarray, "3"]:
    total = weights.sum(dtype=float)
    sums = [weights.sum(axis=others, dtype=float) for others in ((1, 2), (0, 2), (0, 1))]
    return np.array([float(np.arange(len(line)) @ line / total) for line in sums])


def _ball(
    shape: tuple[int, ...], voxel_size_mm: float, centre_mm: Float[np.ndarray, "3"], radius: float
) -> Mask:
    x, y, z = np.ogrid[tuple(slice(count) for count in shape)]
    squares = [
        (place * voxel_size_mm - middle) ** 2
        for place, middle in zip((x, y, z), centre_mm, strict=True)
    ]
    return squares[0] + squares[1] + squares[2] < radius**2


def is_skull_stripped(voxels: Voxels, head: Head, parameters: SegmentMriParameters) -> bool:
    """Return whether hardly any dark bone lies below the surface of the upper half.

    Parameters
    ----------
    voxels : (i, j, k) that the head was found in.
    head : what was found.
    parameters : how deep bone lies, how dark it is, and how much of it there must be.
    """
    size = parameters.skin_voxel_mm
    depth = depth_mm(np.pad(head.mask, 1), np.full(3, size))[1:-1, 1:-1, 1:-1]
    below = (depth > parameters.bone_depths_mm[0]) & (depth < parameters.bone_depths_mm[1])
    below[:, :, : head.middle] = False
    lowest, brain = head.levels.lowest, head.levels.brain
    dark = voxels[below] < lowest + parameters.brightest_bone * (brain - lowest)
    return bool(dark.mean() < parameters.least_bone_share)
