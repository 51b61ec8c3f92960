"""Where fluid ends that was found: at the half height between it and the wall around it."""

import numpy as np
from jaxtyping import Float, Float32

from nodes.geometry.masks import (
    connected_parts,
    enclosed_holes,
    grow_mask,
    parts_that_meet,
)
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import Box, CtScan, Mask


def bounded_fluid(
    scan: CtScan,
    box: Box,
    core: Mask,
    lung: Mask,
    tissue: Mask,
    levels_hu: tuple[float, float],
    parameters: SegmentCtParameters,
) -> Mask:
    """Return the fluid up to the half height between it and the wall around it.

    The lung counts as fluid while the image is smoothed: what is left of the cavity is one
    even region, and only its outer border is looked for.
    """
    from scipy import ndimage

    fluid_hu, wall_hu = levels_hu
    fat_border = (parameters.fat_hu + fluid_hu) / 2
    noise_hu = float(np.std(scan.hu[box][core]))
    width = _width_mm(noise_hu, wall_hu - fluid_hu, scan, parameters) / scan.spacing
    rim = tissue & beside(beside(lung))
    hu = scan.hu[box].astype(np.float32)
    beyond = _mean_over(tissue & ~rim, hu, width)
    fat = tissue & np.where(rim, beyond < fat_border, hu < fat_border)
    partly_lung = rim & (hu < fluid_hu)
    hu = np.clip(hu, -80, 140)
    hu[lung | partly_lung] = fluid_hu
    hu[(~tissue & ~lung) | fat | scan.closed[box]] = wall_hu
    even = ndimage.gaussian_filter(hu, width, truncate=3)
    middle_hu = (fluid_hu + wall_hu) / 2
    # Where the lung touches the wall, a rim is partly lung and partly wall, and no fluid.
    touching = beside(lung) & (
        _mean_over(tissue & ~beside(lung), hu, np.maximum(width, 1.0)) > middle_hu
    )
    fluid = (even < middle_hu) & tissue & ~touching & ~scan.closed[box]
    core = core | _layers(fluid, core, lung, hu, scan, parameters)
    near = grow_mask(lung, parameters.effusion_film_mm, scan.spacing)
    taper_mm = parameters.effusion_taper_mm
    fluid = _without_sheets(fluid, near, core, scan.spacing, taper_mm)
    # Noise leaves specks; those that fluid and lung enclose are fluid.
    specks = enclosed_holes(fluid | lung) & tissue & ~scan.closed[box]
    return fluid | parts_that_meet(specks, beside(fluid))


def _layers(
    fluid: Mask,
    core: Mask,
    lung: Mask,
    hu: Float32[np.ndarray, "x y z"],
    scan: CtScan,
    parameters: SegmentCtParameters,
) -> Mask:
    """Return further fluid: as dark as the core, smaller, three voxels thick, a layer on its lung.

    So is fluid between lung and diaphragm. The diaphragm's own thickness keeps stomach and bowel
    from lying on the lung with much of their surface.
    """
    from scipy import ndimage

    thick = ndimage.binary_opening(fluid)
    parts, sizes = connected_parts(thick)
    count = len(sizes) + 1
    met = np.bincount(parts[core], minlength=count)[1:] > 0
    near = grow_mask(lung, parameters.effusion_film_mm, scan.spacing)
    surface = thick & ~ndimage.binary_erosion(thick)
    contact, whole = (
        np.bincount(parts[mask], minlength=count)[1:] for mask in (surface & near, surface)
    )
    mean_hu = np.bincount(parts.ravel(), weights=hu.ravel(), minlength=count)[1:] / sizes
    alike = abs(mean_hu - hu[core].mean()) <= parameters.effusion_tolerance_hu
    large = scan.millilitres(1) * sizes >= parameters.smallest_layer_ml
    kept = ~met & alike & large & (sizes < core.sum())
    kept &= contact >= parameters.effusion_contact_share * whole
    return np.concatenate([[False], kept])[parts]


def _width_mm(
    noise_hu: float, contrast_hu: float, scan: CtScan, parameters: SegmentCtParameters
) -> float:
    """Return the width of the Gaussian that makes noise small against half the contrast.

    A Gaussian of width s averages white noise as the mean of (4 pi)^(3/2) s^3 / v voxels of volume
    v does.
    """
    voxels = (parameters.effusion_noise_sigmas * noise_hu / (contrast_hu / 2)) ** 2
    enough = float(np.cbrt(voxels * scan.spacing.prod()) / np.sqrt(4 * np.pi))
    return max(parameters.effusion_smoothing_mm, enough)


def _mean_over(
    mask: Mask, values: Float32[np.ndarray, "x y z"], width: Float[np.ndarray, "3"]
) -> Float32[np.ndarray, "x y z"]:
    """Return the mean around each voxel over those of the mask alone; 0 where there are none."""
    from scipy import ndimage

    weight = ndimage.gaussian_filter(mask.astype(np.float32), width, truncate=3)
    total = ndimage.gaussian_filter(np.where(mask, values, np.float32(0)), width, truncate=3)
    return np.where(weight > 1e-3, total / np.maximum(weight, np.float32(1e-3)), np.float32(0))


def _without_sheets(
    fluid: Mask, near_lung: Mask, core: Mask, spacing_mm: Float[np.ndarray, "3"], taper_mm: float
) -> Mask:
    """Return the fluid that is joined to the core.

    Blurred borders make sheets that look like fluid, one or two voxels thin, between fat and muscle
    and around the lung. Such a sheet counts only beside the lung, as the thinning end of a layer.
    """
    from scipy import ndimage

    fluid = parts_that_meet(fluid, core)
    thick = parts_that_meet(ndimage.binary_opening(fluid), core)
    end = near_lung & grow_mask(thick, taper_mm, spacing_mm)
    return parts_that_meet(fluid & (thick | end), core)


def beside(mask: Mask) -> Mask:
    """Return the mask and the voxels that share a face with it: these are partly of it."""
    from scipy import ndimage

    return ndimage.binary_dilation(mask)
