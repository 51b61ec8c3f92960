"""Bone of one head in a straight and in a tilted scan, over the range that both show.

The scans are laid together by rigid registration. The tilted one has slices of 2.5 mm, the straight
one of 1 mm: thick slices blur thin bone below any threshold, so the straight scan is averaged over
sqrt(2.5^2 - 1^2) = 2.29 mm; of all widths this one leaves the smallest differences between them.
"""

from typing import NamedTuple

import numpy as np
import SimpleITK as sitk

from nodes.geometry.grids import Volume, spacing_mm

SLICE_WIDTH_MM = 2.29
OUTSIDE = -5000.0


class Scans(NamedTuple):
    """Values of both scans on the tilted one's grid, and where both were scanned."""

    straight: np.ndarray
    tilted: np.ndarray
    shared: np.ndarray


def lay_together(
    straight: Volume, tilted: Volume, every: int = 1, width_mm: float = SLICE_WIDTH_MM
) -> Scans:
    """Bring the straight scan to the tilted one's grid, or to every nth pixel of its planes."""
    fixed, moving = to_image(tilted), to_image(straight)
    # Not what straightening set outside the scan (nor the emptiest air, which holds no bone).
    scanned = sitk.Cast(fixed > -1024, sitk.sitkUInt8)
    found = register(*(sitk.BinShrink(image, [8, 8, 1]) for image in (fixed, moving, scanned)))
    fixed, scanned = (sitk.Shrink(image, [every, every, 1]) for image in (fixed, scanned))
    other = averaged(moving, fixed, found, width_mm)
    shared = (sitk.GetArrayFromImage(scanned) > 0) & (other > OUTSIDE / 2)
    return Scans(other, sitk.GetArrayFromImage(fixed), shared)


def bone_ratio(scans: Scans, threshold_hu: float) -> float:
    """Return how much more of the shared range is bone in the tilted scan."""
    counts = ((s[scans.shared] >= threshold_hu).sum() for s in (scans.tilted, scans.straight))
    return float(next(counts) / next(counts))


def to_image(volume: Volume) -> sitk.Image:
    image = sitk.GetImageFromArray(volume.voxels.transpose(2, 1, 0).astype(np.float32))
    spacing = spacing_mm(volume.patient_from_index)
    image.SetSpacing(spacing.tolist())
    image.SetDirection((volume.patient_from_index[:3, :3] / spacing).ravel().tolist())
    image.SetOrigin(volume.patient_from_index[:3, 3].tolist())
    return image


def register(fixed: sitk.Image, moving: sitk.Image, scanned: sitk.Image) -> sitk.Transform:
    """Return the rigid motion with the least mean squares where the fixed image was scanned."""
    method = sitk.ImageRegistrationMethod()
    method.SetMetricAsMeanSquares()
    method.SetInterpolator(sitk.sitkLinear)
    method.SetMetricFixedMask(scanned)
    method.SetOptimizerAsRegularStepGradientDescent(2.0, 1e-3, 100)
    method.SetOptimizerScalesFromPhysicalShift()
    kind = sitk.CenteredTransformInitializerFilter.MOMENTS
    start = sitk.CenteredTransformInitializer(fixed, moving, sitk.Euler3DTransform(), kind)
    method.SetInitialTransform(start, inPlace=False)
    return method.Execute(fixed, moving)


def averaged(
    moving: sitk.Image, grid: sitk.Image, found: sitk.Transform, width_mm: float
) -> np.ndarray:
    """Return values on the grid, each the mean over a width along the grid's third axis."""
    normal = np.reshape(grid.GetDirection(), (3, 3))[:, 2]
    total = np.zeros(grid.GetSize()[::-1])
    shifts = width_mm * (np.arange(5) - 2) / 5
    for shift in shifts:
        shifted = sitk.Image(grid)
        shifted.SetOrigin(np.array(grid.GetOrigin()) + shift * normal)
        values = sitk.Resample(moving, shifted, found, sitk.sitkLinear, OUTSIDE)
        total += sitk.GetArrayFromImage(values)
    return total / len(shifts)
