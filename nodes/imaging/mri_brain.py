"""The brain's tissue in a T1-weighted MRI, from the surface that lies on it."""

import numpy as np
from jaxtyping import Bool, Float32

from nodes.geometry.masks import (
    bounding_box,
    depth_mm,
    enclosed_holes,
    grow_mask,
    largest_part,
    shrink_mask,
)
from nodes.imaging.cubic_masks import close_widely
from nodes.imaging.parameters import SegmentMriParameters

Mask = Bool[np.ndarray, "i j k"]
Voxels = Float32[np.ndarray, "i j k"]

BIAS_SHRINKING = 4  # the bias is smooth: every fourth voxel shows it
BIAS_STEPS = (30, 30, 20)  # at each level of control points; fields of MRI converge within
SMALLEST_VALUE = 1e-3  # share of the brain's, so that its logarithm exists


def even_intensities(voxels: Voxels, inside: Mask, lowest: float) -> Voxels:
    """Divide by the smooth bias field that N4 finds within a mask [Tustison2010].

    Returns
    -------
    0 at `lowest`, 1 at the median within the mask.
    """
    import SimpleITK as sitk

    values = (voxels - np.float32(lowest)) / np.float32(np.median(voxels[inside]) - lowest)
    image = sitk.GetImageFromArray(np.maximum(values, np.float32(SMALLEST_VALUE)))
    mask = sitk.GetImageFromArray(inside.astype(np.uint8))
    correction = sitk.N4BiasFieldCorrectionImageFilter()
    correction.SetMaximumNumberOfIterations(BIAS_STEPS)
    correction.SetNumberOfThreads(1)  # sums in one order, so that the result is the same each time
    correction.Execute(
        sitk.Shrink(image, [BIAS_SHRINKING] * 3), sitk.Shrink(mask, [BIAS_SHRINKING] * 3)
    )
    bias = sitk.GetArrayFromImage(correction.GetLogBiasFieldAsImage(image))
    values = values / np.exp(bias)
    return (values / np.median(values[inside])).astype(np.float32)


def share_near_skin(
    surface: Mask, skin: Mask, voxel_size_mm: float, parameters: SegmentMriParameters
) -> float:
    """Return the share of the upper half of a surface that lies in the scalp, where no brain is.

    Parameters
    ----------
    surface : (i, j, k) within the surface.
    skin : (i, j, k) within the skin.
    voxel_size_mm : edge of the cubic voxels.
    parameters : thickness of what is surely scalp.
    """
    spacing = np.full(3, voxel_size_mm)
    border = surface & ~shrink_mask(surface, voxel_size_mm, spacing)
    border[:, :, : int(np.median(np.nonzero(surface)[2]))] = False
    depth = depth_mm(np.pad(skin, 1), spacing)[1:-1, 1:-1, 1:-1]
    return float(np.mean(depth[border] < parameters.sure_scalp_mm))


def find_tissue(
    values: Voxels,
    surface: Mask,
    skin: Mask,
    voxel_size_mm: float,
    parameters: SegmentMriParameters,
) -> Mask:
    """Return the brain near whose outside the surface lies.

    What is as bright as brain within the surface is cut where it is darkest on the way to the skin,
    and where it is thin (membranes, vessels, nerves); the largest part grows back to its own edge,
    and sulci are filled.

    Parameters
    ----------
    values : (i, j, k) 1 at the brain's median.
    surface : (i, j, k) within the surface.
    skin : (i, j, k) within the skin.
    voxel_size_mm : edge of the cubic voxels.
    parameters : levels and widths.
    """
    spacing = np.full(3, voxel_size_mm)
    bright = (values > parameters.darkest_tissue) & (values < parameters.brightest_tissue)
    near = grow_mask(surface, parameters.surface_reach_mm, spacing)
    tissue = bright & near & _cut_from_skin(values, surface, skin, voxel_size_mm, parameters)
    radius = parameters.brain_opening_mm
    core = largest_part(shrink_mask(tissue, radius, spacing))
    brain = largest_part(tissue & grow_mask(core, 1.5 * radius, spacing))
    return fill_sulci(brain, parameters.sulcus_closing_mm, voxel_size_mm)


def _cut_from_skin(
    values: Voxels,
    surface: Mask,
    skin: Mask,
    voxel_size_mm: float,
    parameters: SegmentMriParameters,
) -> Mask:
    """Part the head along the darkest ways between the deep brain and the scalp, by watershed.

    Where bone is thinner than a voxel it is only a little darker than brain and muscle, and the
    surface can break through: no threshold finds it, the watershed does [Hahn2000].
    """
    from skimage import segmentation

    spacing = np.full(3, voxel_size_mm)
    from_skin = depth_mm(np.pad(skin, 1), spacing)[1:-1, 1:-1, 1:-1]
    from_surface = depth_mm(surface, spacing)
    brain = (from_surface > parameters.sure_brain_mm) & (from_skin > parameters.sure_depth_mm)
    outside = (from_skin < parameters.sure_scalp_mm) | (from_surface < -parameters.sure_brain_mm)
    markers = np.where(brain, 2, np.where(outside, 1, 0)).astype(np.int8)
    darkness = np.uint8(255) - (255 * np.clip(values, 0, 1)).astype(np.uint8)
    box = bounding_box(surface, int(2 * parameters.sure_brain_mm / voxel_size_mm))
    parted = np.zeros_like(surface)
    parted[box] = segmentation.watershed(darkness[box], markers[box]) == 2
    return parted


def find_remains(bright: Mask, voxel_size_mm: float, parameters: SegmentMriParameters) -> Mask:
    """Return the brain where nothing but the brain is left in the image."""
    spacing = np.full(3, voxel_size_mm)
    core = largest_part(shrink_mask(bright, parameters.brain_opening_mm, spacing))
    brain = bright & grow_mask(core, 1.5 * parameters.brain_opening_mm, spacing)
    return fill_sulci(brain, parameters.sulcus_closing_mm, voxel_size_mm)


def fill_sulci(brain: Mask, radius_mm: float, voxel_size_mm: float) -> Mask:
    """Add what a ball of this radius cannot reach from outside, and all that is enclosed."""
    closed = close_widely(brain, radius_mm, voxel_size_mm)
    return closed | enclosed_holes(closed)
