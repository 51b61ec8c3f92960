"""Fluid in a pleural cavity: found on coarse voxels, where noise is low, and bounded on fine ones.

Fluid (about 0 to 20 HU) and muscle (about 50) differ by little more than the noise, so both are
averaged first. Fatty livers, bile and cysts are as dark; what tells an effusion apart is its
place: it lies outside of its lung, between lung and ribs.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32

from nodes.geometry.masks import (
    bounding_box,
    connected_parts,
    enclosed_holes,
    grow_mask,
    parts_that_meet,
)
from nodes.imaging.coarse_blocks import block_sums, coarse_step, refined
from nodes.imaging.ct_lungs import LEFT
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import Box, CtScan, Mask
from nodes.imaging.region_growing import seeds_in_tissue


class CoarseTissue(NamedTuple):
    """Tissue averaged over blocks of voxels and their neighbours.

    Parameters
    ----------
    step : voxels a block along each axis.
    spacing : mm between blocks.
    tissue : where at least some tissue is.
    mean_hu, noise_hu : mean and standard deviation around each block.
    """

    step: tuple[int, ...]
    spacing: Float32[np.ndarray, "3"]
    tissue: Bool[np.ndarray, "x y z"]
    mean_hu: Float32[np.ndarray, "x y z"]
    noise_hu: Float32[np.ndarray, "x y z"]


def find_effusion(
    scan: CtScan,
    tissue: Mask,
    lungs: dict[int, Mask],
    dents: Mask,
    parameters: SegmentCtParameters,
) -> Mask:
    """Return the fluid around the lungs; nothing where there is none to speak of.

    Parameters
    ----------
    scan : the CT.
    tissue : what is neither air, lung nor bone inside the body.
    lungs : lung by side (LEFT, RIGHT), with its vessels.
    dents : what was filled as vessels or dents of the lungs; fluid in it is no lung.
    """
    result = np.zeros_like(tissue)
    if not lungs or not tissue.any():
        return result
    whole = np.logical_or.reduce(list(lungs.values()))
    coarse = _coarse_tissue(scan, tissue & ~_beside(whole), parameters)
    for side, core in _cores(scan, coarse, lungs, parameters).items():
        fluid_hu = _fluid_hu(coarse, core)
        wall_hu = _wall_hu(coarse, core, fluid_hu, parameters)
        core = refined(core, coarse.step, tissue.shape) & tissue
        box = bounding_box(core | lungs[side], round(10 / float(scan.spacing.min())))
        result[box] |= _bounded(
            scan, box, core[box], lungs[side][box], tissue[box], (fluid_hu, wall_hu), parameters
        )
        fluid = dents & (scan.hu > parameters.lung_threshold_hu)
        fluid &= scan.hu < (fluid_hu + wall_hu) / 2
        result |= fluid & grow_mask(result, parameters.effusion_dent_mm, scan.spacing)
    return result


def _beside(mask: Mask) -> Mask:
    """Return the mask and the voxels that share a face with it: these are partly of it."""
    from scipy import ndimage

    return ndimage.binary_dilation(mask)


def _coarse_tissue(scan: CtScan, tissue: Mask, parameters: SegmentCtParameters) -> CoarseTissue:
    from scipy import ndimage

    step = coarse_step(scan.spacing, parameters.coarse_mm)
    spacing = (scan.spacing * step).astype(np.float32)
    chosen = tissue & (scan.hu > parameters.fat_hu - 50) & (scan.hu < parameters.bone_threshold_hu)
    hu = np.where(chosen, scan.hu, 0).astype(np.float32)
    width = parameters.effusion_search_mm / spacing
    weight, total, squares = (
        ndimage.gaussian_filter(block_sums(values, step), width, truncate=3)
        for values in (chosen.astype(np.float32), hu, hu * hu)
    )
    weight = np.maximum(weight, np.float32(1e-3))
    mean = total / weight
    noise = np.sqrt(np.maximum(squares / weight - mean * mean, 0))
    return CoarseTissue(step, spacing, weight > 0.4 * np.prod(step), mean, noise)


def _cores(
    scan: CtScan, coarse: CoarseTissue, lungs: dict[int, Mask], parameters: SegmentCtParameters
) -> dict[int, Mask]:
    """Return by side what is certainly fluid, on coarse voxels."""
    blocks = {
        side: block_sums(lung.astype(np.float32), coarse.step) > 0.5 * np.prod(coarse.step)
        for side, lung in lungs.items()
    }
    seeded = _grown_from_seeds(scan, coarse, parameters)
    if seeded.any():
        nearest = min(blocks, key=lambda side: _distance(seeded, blocks[side], coarse))
        return {nearest: seeded}
    fluid = _fluid_like(coarse, parameters)
    cores = {}
    for side, lung in blocks.items():
        core = _effusions(fluid, _outside_of(lung, side), coarse, scan, parameters)
        if core.any():
            cores[side] = core
    return cores


def _distance(mask: Mask, other: Mask, coarse: CoarseTissue) -> float:
    """Return the distance of two masks' middles along x, mm."""
    x = [np.flatnonzero(m.any(axis=(1, 2))).mean() for m in (mask, other)]
    return abs(float(x[0] - x[1])) * float(coarse.spacing[0])


def _fluid_like(coarse: CoarseTissue, parameters: SegmentCtParameters) -> Mask:
    """Return where the mean is that of fluid, and the values no more mixed than noise makes them.

    The quietest tissue shows the noise; blurred borders of fat and muscle average to fluid as
    well, but are mixed.
    """
    from scipy import ndimage

    if not coarse.tissue.any():
        return coarse.tissue
    quiet = float(np.percentile(coarse.noise_hu[coarse.tissue], parameters.quiet_percent))
    even = coarse.noise_hu < 1.5 * quiet + parameters.effusion_tolerance_hu / 2
    low = parameters.lowest_effusion_hu - parameters.effusion_tolerance_hu
    high = parameters.highest_effusion_hu + parameters.effusion_tolerance_hu
    fluid = coarse.tissue & even & (coarse.mean_hu > low) & (coarse.mean_hu < high)
    return ndimage.binary_opening(fluid)


def _outside_of(lung: Mask, side: int) -> Mask:
    """Return what has the lung beside it in the axial plane, but neither lateral of it nor above.

    That is where fluid gathers around a lung, before, behind or lateral of it. Liver and stomach
    reach up into the lung's base and have lung above or lateral of them, the heart lateral.
    """
    reach = np.logical_or.accumulate
    front, back = reach(lung, axis=1), reach(lung[:, ::-1], axis=1)[:, ::-1]
    lower, higher = reach(lung, axis=0), reach(lung[::-1], axis=0)[::-1]
    above = reach(lung[:, :, ::-1], axis=2)[:, :, ::-1]
    medial, lateral = (lower, higher) if side == LEFT else (higher, lower)
    return (front | back | medial) & ~(lateral | above)


def _effusions(
    fluid: Mask,
    outside: Mask,
    coarse: CoarseTissue,
    scan: CtScan,
    parameters: SegmentCtParameters,
) -> Mask:
    """Return the parts that are large enough, of fluid's mean, and mostly outside of the lung."""
    parts, sizes = connected_parts(fluid)
    count = len(sizes) + 1
    total = np.bincount(parts.ravel(), weights=coarse.mean_hu.ravel(), minlength=count)[1:]
    beyond = np.bincount(parts[outside], minlength=count)[1:]
    whole = np.maximum(sizes, 1)
    kept = (
        (scan.millilitres(1) * np.prod(coarse.step) * sizes >= parameters.smallest_effusion_ml)
        & (total / whole >= parameters.lowest_effusion_hu)
        & (total / whole <= parameters.highest_effusion_hu)
        & (beyond / whole >= parameters.effusion_outside_share)
    )
    return np.concatenate([[False], kept])[parts]


def _grown_from_seeds(scan: CtScan, coarse: CoarseTissue, parameters: SegmentCtParameters) -> Mask:
    """Return what is connected to a person's seeds and is like their surroundings."""
    import SimpleITK as sitk

    within = (parameters.fat_hu, parameters.bone_threshold_hu)
    seeds = seeds_in_tissue(scan, parameters.effusion_seeds_patient_mm, within, "effusion")
    if not len(seeds):
        return np.zeros_like(coarse.tissue)
    even = np.where(coarse.tissue, coarse.mean_hu, np.float32(-1000))
    grown = sitk.ConfidenceConnected(
        sitk.GetImageFromArray(even.astype(np.float32)),
        [tuple(int(n) for n in (seed // coarse.step)[::-1]) for seed in seeds],
        numberOfIterations=2,
        multiplier=2.5,
        initialNeighborhoodRadius=2,
    )
    return sitk.GetArrayFromImage(grown).astype(bool) & coarse.tissue


def _fluid_hu(coarse: CoarseTissue, core: Mask) -> float:
    """Return the value of the fluid, where it is thick enough from its inside."""
    from scipy import ndimage

    inside = ndimage.binary_erosion(core)
    return float(np.median(coarse.mean_hu[inside if inside.sum() > 30 else core]))


def _wall_hu(
    coarse: CoarseTissue, core: Mask, fluid_hu: float, parameters: SegmentCtParameters
) -> float:
    """Return the value of the tissue around the fluid."""
    shell = grow_mask(core, 14.0, coarse.spacing) & ~grow_mask(core, 5.0, coarse.spacing)
    values = coarse.mean_hu[shell & coarse.tissue]
    values = values[(values > fluid_hu + 20) & (values < 110)]
    return float(np.median(values)) if len(values) > 20 else parameters.soft_tissue_hu + 10


def _bounded(
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
    rim = tissue & _beside(_beside(lung))
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
    touching = _beside(lung) & (
        _mean_over(tissue & ~_beside(lung), hu, np.maximum(width, 1.0)) > middle_hu
    )
    fluid = (even < middle_hu) & tissue & ~touching & ~scan.closed[box]
    core = core | _layers(fluid, core, lung, hu, scan, parameters)
    near = grow_mask(lung, parameters.effusion_film_mm, scan.spacing)
    taper_mm = parameters.effusion_taper_mm
    fluid = _without_sheets(fluid, near, core, scan.spacing, taper_mm)
    # Noise leaves specks; those that fluid and lung enclose are fluid.
    specks = enclosed_holes(fluid | lung) & tissue & ~scan.closed[box]
    return fluid | parts_that_meet(specks, _beside(fluid))


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
