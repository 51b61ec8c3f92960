"""Where straight needles start and which way they point: the skin, and a cone about its normal."""

import numpy as np
from jaxtyping import Bool, Float

from nodes.environment.resampling import resample_mask
from nodes.geometry.frames import transform_points
from nodes.geometry.masks import enclosed_holes

Points = Float[np.ndarray, "n 3"]

SMOOTH_CELLS = 1.0  # of the shape whose normals count: pores and clothes are not meant
MARGIN_CELLS = 6  # beyond the reach of the smoothing, 4, and of the cells beside it
HALF = 0.4999  # no simple fraction, as a cell exactly at the level gives collapsed triangles


def skin_points(
    body: Bool[np.ndarray, "i j k"], spacing: Float[np.ndarray, "3"], apart_mm: float
) -> tuple[Points, Points]:
    """Return points of the skin, about one for each cell of its smoothed shape, and inward normals.

    Where the image cuts the body there is no skin: the body is carried on beyond the edge, so that
    it is not rounded there.

    Parameters
    ----------
    body : all that is inside the skin; not empty.
    spacing : of its voxels, mm.
    apart_mm : size of the cells.

    Returns
    -------
    Points and unit normals, mm along the grid's axes from the first voxel's centre.
    """
    from scipy import ndimage
    from skimage.measure import marching_cubes

    beyond = np.ceil(MARGIN_CELLS * apart_mm / spacing).astype(int)
    wider = np.pad(body, [(n, n) for n in beyond], mode="edge")
    share, grid_from_cell = resample_mask(wider, np.diag([*spacing, 1.0]), apart_mm)
    grid_from_cell[:3, 3] -= beyond * spacing
    share[enclosed_holes(share > HALF)] = 1
    shape = ndimage.gaussian_filter(share, SMOOTH_CELLS)
    if shape.max() <= HALF:
        return np.empty((0, 3)), np.empty((0, 3))
    places, _, _, _ = marching_cubes(shape, HALF, allow_degenerate=False)
    places = places.astype(float)
    # Places are often at whole and half cells, where rounding would be left to noise.
    _, one_each = np.unique(np.floor(places + 0.25).astype(int), axis=0, return_index=True)
    places = places[one_each]
    slopes = [ndimage.map_coordinates(s, places.T, order=1) for s in np.gradient(shape)]
    inward = np.stack(slopes, axis=1).astype(float)
    inward /= np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), 1e-12)
    points = transform_points(grid_from_cell, places)
    index, size = points / spacing, np.array(body.shape)
    within = ((index > -0.5) & (index < size - 0.5)).all(axis=1)
    return points[within], inward[within]


def cone_directions(
    normals: Points, largest_tilt_deg: float, tilt_step_deg: float
) -> Float[np.ndarray, "n d 3"]:
    """Return directions about each normal: itself first, then rings of larger and larger tilt."""
    cone = _cone(largest_tilt_deg, tilt_step_deg)
    # Any axis will do that is not near the normal; noise must not choose between two.
    upright = abs(normals[:, 2:]) > 0.9
    helper = np.where(upright, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    first = np.cross(normals, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    frame = np.stack([first, np.cross(normals, first), normals], axis=1)
    return np.ascontiguousarray(np.einsum("dl,nlx->ndx", cone, frame))


def _cone(largest_tilt_deg: float, tilt_step_deg: float) -> Float[np.ndarray, "d 3"]:
    """Return unit vectors about +z, neighbours about one step apart."""
    rings = [np.array([[0.0, 0.0, 1.0]])]
    count = int(np.floor(largest_tilt_deg / tilt_step_deg + 1e-9))
    for tilt in np.radians(tilt_step_deg * np.arange(1, count + 1)):
        around = int(np.ceil(2 * np.pi * np.sin(tilt) / np.radians(tilt_step_deg)))
        turn = 2 * np.pi * np.arange(around) / around
        across = np.sin(tilt) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        rings.append(np.column_stack([across, np.full(around, np.cos(tilt))]))
    return np.concatenate(rings)
