"""The two lungs: air inside the body, parted where they touch, with their vessels."""

import numpy as np
from jaxtyping import Float, Int, Shaped, UInt8

from nodes.geometry.masks import (
    bounding_box,
    close_mask,
    connected_parts,
    depth_mm,
    grow_mask,
    largest_part,
    shrink_mask,
)
from nodes.imaging.coarse_blocks import coarse_step, refined
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import Box, CtScan, Mask
from nodes.imaging.region_growing import seeds_in_tissue

LEFT, RIGHT = 1, -1  # the side of a lung along x
NEITHER, ON_LEFT, ON_RIGHT, ON_BOTH = 0, 1, 2, 3
Sides = UInt8[np.ndarray, "x y z"]


def find_lungs(
    scan: CtScan, free: Mask, airway: Mask, parameters: SegmentCtParameters
) -> dict[int, Mask]:
    """Return the air and fine tissue of the lungs by side, each in one part, without vessels.

    Parameters
    ----------
    scan : the CT.
    free : where lung may be: inside the body and outside of barriers.
    airway : the air in trachea and bronchi, which is no lung.
    """
    seeds = _seeds(scan, parameters)
    air = _lung_air(scan, free, airway, np.concatenate(list(seeds.values())), parameters)
    if not air.any():
        return {}
    box = bounding_box(air, 6)
    offset = np.array([side.start for side in box])
    local = {side: points - offset for side, points in seeds.items()}
    sides = _by_side(air[box], scan, box, local, parameters)
    lungs = {}
    for side, number in ((LEFT, ON_LEFT), (RIGHT, ON_RIGHT)):
        one = largest_part(sides == number)
        if one.any():
            open_to_it = free[box] & ~airway[box] & ((sides == number) | (sides == NEITHER))
            lungs[side] = np.zeros_like(free)
            lungs[side][box] = _to_its_border(one, open_to_it, scan, box, parameters)
            free = free & ~lungs[side]
    return lungs


def fill_vessels(
    lung: Mask,
    tissue: Mask,
    spacing_mm: Float[np.ndarray, "3"],
    parameters: SegmentCtParameters,
) -> Mask:
    """Return the lung with the vessels in it and the dents at its root."""
    box = bounding_box(lung, int(parameters.lung_closing_mm / float(spacing_mm.min())) + 2)
    closed = close_mask(lung[box], parameters.lung_closing_mm, spacing_mm)
    filled = lung.copy()
    filled[box] = largest_part(lung[box] | (closed & tissue[box]))
    return filled


def _seeds(scan: CtScan, parameters: SegmentCtParameters) -> dict[int, Int[np.ndarray, "n 3"]]:
    within = (-1100.0, parameters.lung_threshold_hu)
    left, right = parameters.left_lung_seeds_patient_mm, parameters.right_lung_seeds_patient_mm
    return {
        LEFT: seeds_in_tissue(scan, left, within, "left_lung"),
        RIGHT: seeds_in_tissue(scan, right, within, "right_lung"),
    }


def _lung_air(
    scan: CtScan,
    free: Mask,
    airway: Mask,
    seeds: Int[np.ndarray, "n 3"],
    parameters: SegmentCtParameters,
) -> Mask:
    """Return the parts of air that are large and no bare gas (stomach, bowel), or have a seed."""
    # The airway's wall is partly air; unless it is left out, it joins both lungs.
    wall = grow_mask(airway, 1.5 * float(scan.spacing.max()), scan.spacing)
    air = free & (scan.hu < parameters.lung_threshold_hu) & ~wall
    parts, sizes = connected_parts(air)
    means_hu = np.bincount(parts[air], scan.hu[air], len(sizes) + 1)[1:] / np.maximum(sizes, 1)
    large = sizes >= scan.voxels(parameters.smallest_lung_ml)
    kept = np.concatenate([[False], large & (means_hu >= parameters.gas_mean_hu)])
    kept[parts[tuple(seeds.T)]] = True
    kept[0] = False
    return kept[parts]


def _by_side(
    air: Mask,
    scan: CtScan,
    box: Box,
    seeds: dict[int, Int[np.ndarray, "n 3"]],
    parameters: SegmentCtParameters,
) -> Sides:
    """Return which air is of the left lung and which of the right one.

    Where they touch, the air is shrunk until each part lies on one side; from those parts it is
    flooded again, the deepest places first, so that the floods meet at the narrowest place.
    """
    from skimage.segmentation import watershed

    step = coarse_step(scan.spacing, parameters.coarse_mm)
    coarse = np.ascontiguousarray(air[:: step[0], :: step[1], :: step[2]])
    depth = depth_mm(coarse, scan.spacing * step)
    middle = _middle(scan, box, parameters) / step[0]
    marks = {side: points // step for side, points in seeds.items()}
    # Half a voxel of slack: a seed's own voxel may be missing from every other one.
    radii = np.arange(0.0, parameters.widest_lung_contact_mm, float(scan.spacing.max()))
    for radius in radii:
        shrunk = coarse & (depth >= radius)
        markers = _sided(shrunk, middle, marks, parameters.smallest_side_share)
        if (markers == ON_LEFT).any() | (markers == ON_RIGHT).any() and ON_BOTH not in markers:
            break
    else:
        x = np.arange(coarse.shape[0])[:, None, None]
        markers = np.where(coarse, np.where(x > middle, ON_LEFT, ON_RIGHT), NEITHER)
    flooded = watershed(-depth, markers.astype(np.int32), mask=coarse).astype(np.uint8)
    return np.where(air, refined(flooded, step, air.shape), np.uint8(NEITHER))


def _middle(scan: CtScan, box: Box, parameters: SegmentCtParameters) -> float:
    """Return the x index in the box of the patient's middle: the middle of the bones beside."""
    bright = scan.hu[box] >= parameters.bone_threshold_hu
    counts = np.cumsum(np.count_nonzero(bright, axis=(1, 2)))
    if not counts[-1]:
        return len(counts) / 2
    return float(np.searchsorted(counts, counts[-1] / 2))


def _sided(
    air: Mask, middle: float, seeds: dict[int, Int[np.ndarray, "n 3"]], smallest_share: float
) -> Shaped[np.ndarray, "x y z"]:
    """Return for each part of air the side it lies on, or that of the seeds in it."""
    parts, sizes = connected_parts(air)
    x = np.arange(air.shape[0])
    left = np.bincount(parts[x > middle].ravel(), minlength=len(sizes) + 1)[1:]
    share = left / np.maximum(sizes, 1)
    side = np.where(share > 0.85, ON_LEFT, np.where(share < 0.15, ON_RIGHT, ON_BOTH))
    side[sizes < smallest_share * sizes.sum()] = NEITHER
    side = np.concatenate([[NEITHER], side])
    for number, points in ((ON_LEFT, seeds[LEFT]), (ON_RIGHT, seeds[RIGHT])):
        side[parts[tuple(points.T)]] = number
    side[0] = NEITHER
    return side[parts]


def _to_its_border(
    side: Mask, free: Mask, scan: CtScan, box: Box, parameters: SegmentCtParameters
) -> Mask:
    """Return a lung up to the half height between its own density and that of tissue."""
    hu = scan.hu[box]
    step = float(scan.spacing.max())
    core = shrink_mask(side, step, scan.spacing)
    density = float(np.median(hu[core if core.any() else side]))
    border = (density + parameters.soft_tissue_hu) / 2
    return largest_part(grow_mask(side, step, scan.spacing) & free & (hu < border))
