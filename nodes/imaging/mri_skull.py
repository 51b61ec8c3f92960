"""An estimate of the skull: in MRI its bone is as dark as air and fluid, and its marrow as fat.

Its inner side is the brain's smoothed outside and a gap of fluid; its outer side is where, on the
way in from the skin, bright scalp ends and dark bone begins.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from nodes.geometry.masks import bounding_box, grow_mask
from nodes.imaging.cubic_masks import close_widely
from nodes.imaging.parameters import SegmentMriParameters

Mask = Bool[np.ndarray, "i j k"]
Voxels = Float32[np.ndarray, "i j k"]
PerDirection = Float[np.ndarray, " m"]

SUBDIVISIONS = 3  # of an icosahedron: 642 directions, about 10 mm apart on a head
AROUND = 7  # directions that are smoothed together: each and its neighbours
SKIN_STEPS = 2  # at the outer end of a profile, where skin and air mix


class WaysOut(NamedTuple):
    """The voxels around the braincase, each with the place on its inner side that it is nearest to.

    Parameters
    ----------
    distance_mm : (i, j, k) from the inner side.
    starts : (i, j, k) number of the nearest voxel of the inner side.
    places : (n, 3) indices of those voxels.
    directions : (m, 3) unit vectors.
    nearest : (n, 7) directions in which each place lies from the middle, the nearest first.
    """

    distance_mm: Float[np.ndarray, "i j k"]
    starts: Int[np.ndarray, "i j k"]
    places: Int[np.ndarray, "n 3"]
    directions: Float[np.ndarray, "m 3"]
    nearest: Int[np.ndarray, "n 7"]


def find_braincase(brain: Mask, voxel_size_mm: float, parameters: SegmentMriParameters) -> Mask:
    """Return all inside the skull: the brain without its clefts, and the fluid around it."""
    smooth = close_widely(brain, parameters.braincase_closing_mm, voxel_size_mm)
    return grow_mask(smooth, parameters.csf_gap_mm, np.full(3, voxel_size_mm))


def find_skull(
    values: Voxels,
    head: Mask,
    braincase: Mask,
    voxel_size_mm: float,
    parameters: SegmentMriParameters,
) -> Mask:
    """Estimate the skull around the braincase from where dark bone ends.

    Where the skin is too far away to see that (base, face, neck), the skull has the usual
    thickness.

    Parameters
    ----------
    values : (i, j, k) intensities, 0 in air and 1 at the brain's median.
    head : (i, j, k) all inside the skin.
    braincase : (i, j, k) all inside the skull.
    voxel_size_mm : edge of the cubic voxels.
    parameters : usual, thinnest and thickest skull, level of bone.
    """
    box = bounding_box(braincase, int(parameters.skull_reach_mm / voxel_size_mm) + 1)
    ways = _ways_out(braincase[box], voxel_size_mm)
    profiles, inside = _profiles(
        values[box], head[box], ways, voxel_size_mm, parameters.skull_reach_mm
    )
    seen = np.array(
        [
            voxel_size_mm * _bone_end(profile, share, parameters.brightest_bone)
            for profile, share in zip(profiles, inside, strict=True)
        ]
    )
    thickness = np.where(np.isnan(seen), parameters.skull_thickness_mm, seen)
    low, high = parameters.thinnest_skull_mm, parameters.thickest_skull_mm
    thickness = _smoothed(np.clip(thickness, low, high), ways.directions)
    skull = np.zeros_like(braincase)
    at_starts = thickness[ways.nearest[:, :3]].mean(axis=1)
    skull[box] = ~braincase[box] & (ways.distance_mm <= at_starts[ways.starts])
    return skull


def _ways_out(braincase: Mask, voxel_size_mm: float) -> WaysOut:
    import trimesh
    from scipy import ndimage, spatial

    distance, feet = ndimage.distance_transform_edt(
        ~braincase, sampling=voxel_size_mm, return_indices=True
    )
    numbers = np.ravel_multi_index(tuple(feet), braincase.shape)
    found, starts = np.unique(numbers, return_inverse=True)
    places = np.stack(np.unravel_index(found, braincase.shape), axis=1)
    directions = np.array(trimesh.creation.icosphere(subdivisions=SUBDIVISIONS).vertices)
    offsets = places - np.argwhere(braincase).mean(axis=0)
    offsets /= np.linalg.norm(offsets, axis=1, keepdims=True) + 1e-12
    _, nearest = spatial.KDTree(directions).query(offsets, AROUND)
    distance = np.maximum(distance - voxel_size_mm / 2, 0)  # from the border, not a voxel's centre
    return WaysOut(distance, starts.reshape(braincase.shape), places, directions, nearest)


def _profiles(
    values: Voxels, head: Mask, ways: WaysOut, step_mm: float, reach_mm: float
) -> tuple[Float[np.ndarray, "m d"], Float[np.ndarray, "m d"]]:
    """Return the mean value and the share inside the skin, for each direction and distance."""
    steps = int(reach_mm / step_mm)
    around = (ways.distance_mm > 0) & (ways.distance_mm < steps * step_mm)
    direction = ways.nearest[ways.starts[around], 0]
    cell = direction * steps + (ways.distance_mm[around] / step_mm).astype(int)
    size = len(ways.directions) * steps
    count = np.bincount(cell, minlength=size).reshape(-1, steps)
    sums = [np.bincount(cell, field[around], size) for field in (values, head)]
    value, share = (_means(total.reshape(-1, steps), count) for total in sums)
    return value, share


def _means(
    sums: Float[np.ndarray, "m d"], counts: Int[np.ndarray, "m d"]
) -> Float[np.ndarray, "m d"]:
    """Divide, and take what no voxel fell into from before and behind it; 0 where all is empty."""
    means = sums / np.maximum(counts, 1)
    steps = np.arange(counts.shape[1])
    for row, filled in zip(means, counts > 0, strict=True):
        if filled.any() and not filled.all():
            row[~filled] = np.interp(steps[~filled], steps[filled], row[filled])
    return means


def _bone_end(
    profile: Float[np.ndarray, " d"], inside: Float[np.ndarray, " d"], brightest_bone: float
) -> float:
    """Return after how many steps bone ends on one way out, nan where skin or scalp is not reached.

    From the skin inward come bright scalp and then dark bone; bright marrow between the two
    tables of bone comes later and does not mislead.
    """
    skin = int(np.argmin(inside > 0.5)) if (inside <= 0.5).any() else 0
    bright = np.flatnonzero(profile[: max(skin - SKIN_STEPS, 0)] >= brightest_bone)
    if not len(bright):
        return np.nan
    dark = np.flatnonzero(profile[: bright[-1]] < brightest_bone)
    if not len(dark):
        return np.nan
    inner, outer = profile[dark[-1]], profile[dark[-1] + 1]
    part = (brightest_bone - inner) / (outer - inner)
    return float(dark[-1] + 0.5 + part)


def _smoothed(per_direction: PerDirection, directions: Float[np.ndarray, "m 3"]) -> PerDirection:
    """Drop outliers by the median of the neighbours, then average those."""
    from scipy import spatial

    _, around = spatial.KDTree(directions).query(directions, AROUND)
    calm = np.median(per_direction[around], axis=1)
    return calm[around].mean(axis=1)


def shell_skull(braincase: Mask, thickness_mm: float, voxel_size_mm: float) -> Mask:
    """Return a shell of one thickness around the braincase."""
    return grow_mask(braincase, thickness_mm, np.full(3, voxel_size_mm)) & ~braincase


def open_base(
    skull: Mask,
    brain: Mask,
    left_mm: Voxels,
    voxel_size_mm: float,
    parameters: SegmentMriParameters,
) -> Mask:
    """Open the skull below the brain stem's lower end, as the foramen magnum does.

    Parameters
    ----------
    skull, brain : (i, j, k) along the patient's axes.
    left_mm : (i, j, k) distance to the left of the midplane.
    voxel_size_mm : edge of the cubic voxels.
    parameters : radius of the opening.
    """
    radius = parameters.foramen_radius_mm
    middle = np.argwhere(brain & (abs(left_mm) < radius))
    lowest = middle[:, 2].min()
    end = middle[middle[:, 2] <= lowest + radius / voxel_size_mm]
    centre = end[:, :2].mean(axis=0)
    x, y, z = np.ogrid[tuple(slice(count) for count in skull.shape)]
    near = (x - centre[0]) ** 2 + (y - centre[1]) ** 2 <= (radius / voxel_size_mm) ** 2
    return skull & ~(near & (z <= lowest + radius / voxel_size_mm))
