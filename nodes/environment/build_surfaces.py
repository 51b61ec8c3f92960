"""Closed triangle surfaces around the labels of an anatomy."""

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.environment.decimation import decimate, move_to_volume
from nodes.environment.parameters import BuildSurfacesParameters
from nodes.environment.resampling import resample_mask
from nodes.environment.smoothing import smooth_surface
from nodes.errors import BadInput
from nodes.geometry.closed_surfaces import enclosed_volume_mm3, triangle_normals
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap, voxel_volume_mm3
from nodes.geometry.meshes import Mesh, Surfaces

Mask = Bool[np.ndarray, "i j k"]
Affine = Float[np.ndarray, "4 4"]

# Half of a cell; no simple fraction, since a cell exactly at the level gives collapsed triangles.
HALF = 0.4999
# Share of a cell by which a surface may be moved at most to enclose its label's volume.
MOST_MOVED = 0.25
COUNT_TOLERANCE = 0.01  # below the wanted triangles


def build_surfaces(label_map: LabelMap, parameters: BuildSurfacesParameters) -> Surfaces:
    """Bound each label by a watertight surface that winds outward.

    Marching cubes finds where half of a cell is inside [Lorensen1987]; smoothing keeps the volume
    [Taubin1995]; edges collapse by quadric error [Garland1997]; last, all vertices move along their
    normals by one small distance, so that the label's volume is enclosed although parts thinner
    than a cell are lost. The surface of a label that reaches the skin is the skin: it bounds the
    union of all labels. A label cut by the image's edge is closed there.

    Parameters
    ----------
    label_map : anatomy.
    parameters : size of the cells, smoothing, triangles.

    Returns
    -------
    One surface for each label that is not empty, in the order of the labels.

    Raises
    ------
    BadInput where all labels are empty or smaller than a cell.
    """
    meshes, notices = [], []
    for name in label_map.names:
        mask = label_map.voxels > 0 if name in parameters.outer_labels else label_map.mask(name)
        cell_mm = parameters.voxel_size_mm_by_label.get(name, parameters.voxel_size_mm)
        wanted = parameters.triangles_by_label.get(name, parameters.triangles)
        volume_mm3 = np.count_nonzero(mask) * voxel_volume_mm3(label_map.patient_from_index)
        mesh = _surface(mask, label_map.patient_from_index, cell_mm, wanted, volume_mm3, parameters)
        if mesh is None:
            notices.append(f"{name} is empty or smaller than a cell and has no surface")
            continue
        meshes.append((name, mesh))
        difference = enclosed_volume_mm3(mesh) / volume_mm3 - 1
        notices += _volume_notice(name, difference, cell_mm, parameters.volume_tolerance)
        notices += _count_notice(name, len(mesh.triangles), wanted)
    if not meshes:
        raise BadInput(
            "a label map without labelled voxels",
            "at least one label is as large as a cell",
            "correct the segmentation, or set a smaller voxel_size_mm",
        )
    return Surfaces(tuple(meshes), label_map.origin.with_notice(*notices))


def _surface(
    mask: Mask,
    patient_from_index: Affine,
    cell_mm: float,
    wanted: int,
    volume_mm3: float,
    parameters: BuildSurfacesParameters,
) -> Mesh | None:
    from skimage.measure import marching_cubes

    if not mask.any():
        return None
    share, patient_from_cell = resample_mask(mask, patient_from_index, cell_mm)
    if share.max() <= HALF:
        return None
    vertices, triangles, _, _ = marching_cubes(share, HALF, allow_degenerate=False)
    vertices = transform_points(patient_from_cell, vertices.astype(np.float64))
    triangles = _outward(vertices, triangles)
    vertices = smooth_surface(vertices, triangles, parameters.smoothing_steps)
    vertices, triangles = decimate(vertices, triangles, wanted)
    vertices = move_to_volume(vertices, triangles, volume_mm3, MOST_MOVED * cell_mm)
    return Mesh(vertices.astype(np.float32), triangles.astype(np.int32))


def _outward(
    vertices: Float[np.ndarray, "v 3"], triangles: Int[np.ndarray, "t 3"]
) -> Int[np.ndarray, "t 3"]:
    """Wind triangles counter-clockwise seen from outside, that is with positive volume inside.

    Marching cubes winds bright objects inward, and a left-handed grid turns that round.
    """
    areas = triangle_normals(vertices, triangles)
    volume = np.einsum("ni,ni->", vertices[triangles[:, 0]] - vertices[0], areas) / 3
    return triangles if volume > 0 else triangles[:, ::-1]


def _volume_notice(name: str, difference: float, cell_mm: float, tolerance: float) -> list[str]:
    """Say where a surface encloses clearly more or less than its label has."""
    if abs(difference) <= tolerance:
        return []
    much = f"{abs(difference):.0%} {'more' if difference > 0 else 'less'}"
    cell = f"a cell of {cell_mm:g} mm"
    return [f"the surface of {name} encloses {much} than its label, which has parts below {cell}"]


def _count_notice(name: str, count: int, wanted: int) -> list[str]:
    """Say where a surface has not the wanted triangles."""
    if count > wanted:
        why = "with fewer it would not be closed"
    elif count < wanted * (1 - COUNT_TOLERANCE):
        why = "its cells give no more"
    else:
        return []
    return [f"the surface of {name} has {count} triangles, not {wanted}: {why}"]
