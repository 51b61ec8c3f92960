"""What a camera in the free space sees, pixel by pixel, as depth and as the surface's direction."""

import numpy as np
from jaxtyping import Float, Float32

from nodes.geometry.grids import Volume, spacing_mm

Picture = Float32[np.ndarray, "h w"]
PictureOfVectors = Float32[np.ndarray, "h w 3"]


def soften_distance(distance_field: Volume, width_mm: float) -> Volume:
    """Return a distance field in which the steps of cells are smoothed away by a Gaussian.

    Parameters
    ----------
    width_mm : its standard deviation; edges sharper than this are rounded off.
    """
    from scipy import ndimage

    width = width_mm / spacing_mm(distance_field.patient_from_index)
    voxels = ndimage.gaussian_filter(distance_field.voxels, width, output=np.float32)
    told = distance_field.origin.with_notice(f"smoothed by {width_mm:g} mm for pictures")
    return Volume(voxels, distance_field.patient_from_index, distance_field.unit, told)


def render_depth(
    distance_field: Volume,
    patient_from_camera: Float[np.ndarray, "4 4"],
    field_of_view_deg: float,
    pixels: int,
) -> tuple[Picture, PictureOfVectors, PictureOfVectors]:
    """Return what a camera sees of the surface at which the distance is 0 between cells' centres.

    The picture is round and equidistant: the angle from the direction of view grows evenly from
    the middle to the circle that touches the picture's sides, at half the field of view.

    Parameters
    ----------
    distance_field : mm, positive in free space, on cubic cells.
    patient_from_camera : (4, 4) rigid, mm; x right, y down, z forward.
    field_of_view_deg : full angle of the cone, degrees, up to 360.
    pixels : height and width of the picture.

    Returns
    -------
    depth_mm : (h, w) from the camera along each pixel's own ray; nan outside of the circle, and
        everywhere if the camera is not in free space.
    normals : (h, w, 3) unit vectors in patient axes, into the free space.
    points_patient_mm : (h, w, 3) where the rays end.
    """
    from nodes.kernels.depth_rays import trace_depth

    patient_from_index = distance_field.patient_from_index
    cell_mm = float(spacing_mm(patient_from_index)[0])
    depth = np.empty((pixels, pixels), np.float32)
    normals = np.empty((pixels, pixels, 3), np.float32)
    index_from_camera = np.linalg.inv(patient_from_index) @ patient_from_camera
    half = np.deg2rad(field_of_view_deg) / 2
    distance = distance_field.voxels / np.float32(cell_mm)
    trace_depth(distance, index_from_camera, half, depth, normals)
    depth *= np.float32(cell_mm)
    normals = normals @ (patient_from_index[:3, :3].T / cell_mm).astype(np.float32)
    rays = pixel_rays(pixels, field_of_view_deg) @ patient_from_camera[:3, :3].T
    points = patient_from_camera[:3, 3] + depth[..., None] * rays
    return depth, normals, points.astype(np.float32)


def pixel_rays(pixels: int, field_of_view_deg: float) -> Float[np.ndarray, "h w 3"]:
    """Return the unit vectors of the pixels of `render_depth` in the camera's frame."""
    middle = (2 * np.arange(pixels) + 1) / pixels - 1
    x, y = np.meshgrid(middle, middle)
    radius = np.hypot(x, y)
    angle = radius * np.deg2rad(field_of_view_deg) / 2
    out = np.sin(angle) / np.maximum(radius, 1e-12)
    return np.stack([x * out, y * out, np.cos(angle)], axis=-1)
