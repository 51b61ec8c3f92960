"""Bones in a CT: bright parts up to their half height, with their marrow."""

import numpy as np
from jaxtyping import Int, Shaped, UInt8

from nodes.geometry.masks import (
    bounding_box,
    close_mask,
    grow_mask,
    parts_of_size,
    plane_hole_parts,
)
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import Box, CtScan, Mask


def find_bone(scan: CtScan, tissue: Mask, parameters: SegmentCtParameters) -> Mask:
    """Return the bones in the tissue that is neither air nor lung; nothing where there are none."""
    bright = tissue & (scan.hu >= parameters.bone_threshold_hu)
    bright = parts_of_size(bright, scan.voxels(parameters.smallest_bone_ml))
    result = np.zeros_like(bright)
    if bright.any():
        box = bounding_box(bright, 3)
        bone = _without_bloom(bright[box], scan, box, parameters)
        result[box] = bone | (_marrow(bone, scan, box, parameters) & tissue[box])
    return result


def _without_bloom(bright: Mask, scan: CtScan, box: Box, parameters: SegmentCtParameters) -> Mask:
    """Peel off what is bright only by the blur of the bone beside it.

    The border between cortex and soft tissue lies at half their height, which for dense cortex is
    far above the threshold that finds spongy bone; the peak is taken nearby, in thick slices from
    the next slice at least: there lies the bone whose part volume brightens this one.
    """
    from scipy import ndimage

    hu = scan.hu[box]
    size = [2 * max(1, int(parameters.cortex_reach_mm / float(step))) + 1 for step in scan.spacing]
    peak = np.minimum(ndimage.maximum_filter(hu, size=size), np.int16(parameters.cortex_hu))
    bone = bright.copy()
    for _ in range(max(1, round(parameters.bone_bloom_mm / float(scan.spacing.min())))):
        rim = np.flatnonzero(bone & ndimage.binary_dilation(~bone))
        faint = hu.ravel()[rim] < (peak.ravel()[rim] + parameters.soft_tissue_hu) / 2
        bone.ravel()[rim[faint]] = False
    return bone


def _marrow(bone: Mask, scan: CtScan, box: Box, parameters: SegmentCtParameters) -> Mask:
    """Return what bone surrounds in two of the three planes, or in one if it is spongy bone.

    The spinal canal is surrounded in one only and darker than spongy bone, and the skull's inside
    is too large. Narrow gaps in the cortex are closed to look for the marrow.
    """
    closed = close_mask(bone, parameters.bone_closing_mm, scan.spacing)
    votes = np.zeros(bone.shape, np.uint8)
    for axis in range(3):
        votes += _votes(plane_hole_parts(closed, axis), scan.hu[box], axis, scan, parameters)
    marrow = votes >= 2
    rest = grow_mask(marrow, parameters.bone_closing_mm, scan.spacing) & closed
    return marrow | rest | (closed & (scan.hu[box] >= parameters.spongy_hu))


def _votes(
    holes: Int[np.ndarray, "x y z"],
    hu: Shaped[np.ndarray, "x y z"],
    axis: int,
    scan: CtScan,
    parameters: SegmentCtParameters,
) -> UInt8[np.ndarray, "x y z"]:
    """Return a vote for marrow in each hole of a plane that is small enough, two in spongy bone."""
    places = np.flatnonzero(holes)
    numbers = holes.ravel()[places]
    sizes = np.bincount(numbers)
    means_hu = np.bincount(numbers, hu.ravel()[places]) / np.maximum(sizes, 1)
    area_mm2 = sizes * float(np.delete(scan.spacing, axis).prod())
    vote = np.where(means_hu >= parameters.spongy_hu, 2, 1) * (
        area_mm2 <= parameters.largest_marrow_mm2
    )
    votes = np.zeros(holes.size, np.uint8)
    votes[places] = vote[numbers]
    return votes.reshape(holes.shape)
