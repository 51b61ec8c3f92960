"""Fluid in a pleural cavity: found on coarse voxels, where noise is low, and bounded on fine ones.

Fluid (about 0 to 20 HU) and muscle (about 50) differ by little more than the noise, so both are
averaged first. Fatty livers, bile and cysts are as dark; what tells an effusion apart is its
place: it lies outside of its lung, between lung and ribs.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float32

from nodes.geometry.masks import (
    bounding_box,
    connected_parts,
    grow_mask,
)
from nodes.imaging.coarse_blocks import block_sums, coarse_step, refined
from nodes.imaging.ct_fluid_border import beside, bounded_fluid
from nodes.imaging.ct_lungs import LEFT
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import CtScan, Mask
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
    coarse = _coarse_tissue(scan, tissue & ~beside(whole), parameters)
    for side, core in _cores(scan, coarse, lungs, parameters).items():
        fluid_hu = _fluid_hu(coarse, core)
        wall_hu = _wall_hu(coarse, core, fluid_hu, parameters)
        core = refined(core, coarse.step, tissue.shape) & tissue
        box = bounding_box(core | lungs[side], round(10 / float(scan.spacing.min())))
        result[box] |= bounded_fluid(
            scan, box, core[box], lungs[side][box], tissue[box], (fluid_hu, wall_hu), parameters
        )
        fluid = dents & (scan.hu > parameters.lung_threshold_hu)
        fluid &= scan.hu < (fluid_hu + wall_hu) / 2
        result |= fluid & grow_mask(result, parameters.effusion_dent_mm, scan.spacing)
    return result


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
