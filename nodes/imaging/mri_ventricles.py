"""The lateral ventricles: dark fluid deep in both halves of the brain."""

import numpy as np
from jaxtyping import Bool, Float32

from nodes.geometry.masks import connected_parts, depth_mm, enclosed_holes
from nodes.imaging.cubic_masks import close_widely
from nodes.imaging.parameters import SegmentMriParameters

ML_IN_MM3 = 1000.0
Mask = Bool[np.ndarray, "i j k"]
Voxels = Float32[np.ndarray, "i j k"]


def find_ventricles(
    values: Voxels,
    brain: Mask,
    left_mm: Float32[np.ndarray, "i j k"],
    voxel_size_mm: float,
    parameters: SegmentMriParameters,
) -> Mask | None:
    """Find a pair of dark parts, one deep in each half, and what joins the two.

    Cisterns and the cleft between the halves are as dark, but lie at the midplane or nearer to
    the brain's outside.

    Parameters
    ----------
    values : (i, j, k) the brain's intensities, 1 at its median.
    brain : (i, j, k) the brain, ventricles and sulci filled.
    left_mm : (i, j, k) distance to the left of the midplane.
    voxel_size_mm : edge of the cubic voxels.
    parameters : how dark, how deep, how large.

    Returns
    -------
    The ventricles; None where no such pair is seen.
    """
    depth = depth_mm(np.pad(brain, 1), np.full(3, voxel_size_mm))[1:-1, 1:-1, 1:-1]
    fluid = brain & (values < parameters.brightest_fluid) & (depth > parameters.ventricle_edge_mm)
    deep = fluid & (depth > parameters.ventricle_depth_mm)
    sides = []
    for side_mm in (left_mm, -left_mm):
        lateral = fluid & (side_mm > parameters.midline_mm)
        seeds = deep & lateral & (side_mm < parameters.ventricle_reach_mm)
        sides.append(_largest_by_seeds(lateral, seeds))
    if not (sides[0].any() and sides[1].any()):
        return None
    pair = sides[0] | sides[1]
    joint = fluid & close_widely(pair, parameters.ventricle_closing_mm, voxel_size_mm)
    ventricles = pair | joint
    ventricles |= enclosed_holes(ventricles)
    volume_ml = np.count_nonzero(ventricles) * voxel_size_mm**3 / ML_IN_MM3
    likely = parameters.smallest_ventricles_ml <= volume_ml <= parameters.largest_ventricles_ml
    return ventricles if likely else None


def _largest_by_seeds(mask: Mask, seeds: Mask) -> Mask:
    """Return the connected part that holds most of the seeds; nothing where there are none."""
    if not seeds.any():
        return np.zeros_like(mask)
    parts, _ = connected_parts(mask)
    return parts == np.bincount(parts[seeds]).argmax()
