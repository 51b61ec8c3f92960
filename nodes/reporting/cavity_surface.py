"""The surface of the space in which a robot moves, as pages draw it."""

import numpy as np
from jaxtyping import Float, Int

from nodes.geometry.closed_surfaces import enclosed_volume_mm3
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import Volume, spacing_mm
from nodes.geometry.meshes import Mesh

OUTSIDE_CELLS = 2
"""Cells of obstacle around the grid, so that the surface closes where the grid ends."""


def draw_cavity(distance_field: Volume, cell_mm: float, smoothing_mm: float) -> Mesh:
    """Return where a signed distance is 0, by marching cubes [Lorensen1987], wound outward.

    It is a drawing: smoothed, on cells of its own, and no surface to measure on. Cells farther
    than two from the surface do not matter to it, so a wide space costs no more than its surface.

    Parameters
    ----------
    distance_field : signed distance to the walls, positive where the robot may be, mm.
    cell_mm : size of the cells from which the surface is made.
    smoothing_mm : standard deviation of the Gauss filter before that.

    Returns
    -------
    Its mesh; without triangles where nothing is free.
    """
    from scipy.ndimage import gaussian_filter, zoom
    from skimage.measure import marching_cubes

    spacing = spacing_mm(distance_field.patient_from_index)
    reach = OUTSIDE_CELLS * max(cell_mm, float(spacing.max()))
    near = np.clip(distance_field.voxels, -reach, reach).astype(np.float32)
    near = np.pad(near, OUTSIDE_CELLS, constant_values=-reach)
    near = gaussian_filter(near, smoothing_mm / spacing, mode="nearest")
    coarse = zoom(near, np.minimum(spacing / cell_mm, 1), order=1, grid_mode=False)
    if not coarse.min() < 0 < coarse.max():
        return Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    vertices, triangles, _, _ = marching_cubes(coarse, 0.0, allow_degenerate=False)
    scale = (np.array(near.shape) - 1) / (np.array(coarse.shape) - 1)
    indices = vertices.astype(float) * scale - OUTSIDE_CELLS
    points = transform_points(distance_field.patient_from_index, indices)
    return wind_outward(points.astype(np.float32), triangles.astype(np.int32))


def wind_outward(vertices: Float[np.ndarray, "v 3"], triangles: Int[np.ndarray, "t 3"]) -> Mesh:
    """Return a closed mesh whose triangles wind counter-clockwise seen from outside."""
    mesh = Mesh(vertices, triangles)
    if enclosed_volume_mm3(mesh) >= 0:
        return mesh
    return Mesh(vertices, np.ascontiguousarray(triangles[:, ::-1]))
