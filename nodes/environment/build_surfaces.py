"""Closed triangle surfaces around the labels of an anatomy."""

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.environment.parameters import BuildSurfacesParameters
from nodes.environment.resampling import resample_mask
from nodes.environment.smoothing import smooth_surface
from nodes.errors import BadInput
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap, voxel_volume_mm3
from nodes.geometry.meshes import Mesh, Surfaces

Vertices = Float[np.ndarray, "_ 3"]
Triangles = Int[np.ndarray, "_ 3"]

SKIN = "body"
# Half of a cell; no simple fraction, since a cell exactly at the level gives collapsed triangles.
HALF = 0.4999


def build_surfaces(label_map: LabelMap, parameters: BuildSurfacesParameters) -> Surfaces:
    """Bound each label by a watertight surface that winds outward.

    Marching cubes finds where half of a cell is inside [Lorensen1987]; smoothing keeps the volume
    [Taubin1995]; edges collapse by quadric error [Garland1997]. The surface of "body" is the skin:
    it bounds the union of all labels. A label cut by the image's edge is closed there.

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
        mask = label_map.voxels > 0 if name == SKIN else label_map.mask(name)
        mesh = _surface(mask, label_map.patient_from_index, parameters)
        if mesh is None:
            notices.append(f"{name} is empty or smaller than a cell and has no surface")
            continue
        meshes.append((name, mesh))
        notices += _volume_notice(name, mesh, mask, label_map.patient_from_index, parameters)
        if len(mesh.triangles) > parameters.triangles:
            notices.append(f"the surface of {name} has {len(mesh.triangles)} triangles: with"
                           " fewer it would not be closed")  # fmt: skip
    if not meshes:
        raise BadInput(
            "a label map without labelled voxels",
            "at least one label is as large as a cell",
            "correct the segmentation, or set a smaller voxel_size_mm",
        )
    return Surfaces(tuple(meshes), label_map.origin.with_notice(*notices))


def _volume_notice(
    name: str,
    mesh: Mesh,
    mask: Bool[np.ndarray, "i j k"],
    patient_from_index: Float[np.ndarray, "4 4"],
    parameters: BuildSurfacesParameters,
) -> list[str]:
    """Say where a surface encloses clearly more or less than its label has."""
    label_mm3 = np.count_nonzero(mask) * voxel_volume_mm3(patient_from_index)
    difference = enclosed_volume_mm3(mesh) / label_mm3 - 1
    if abs(difference) <= parameters.volume_tolerance:
        return []
    much = f"{abs(difference):.0%} {'more' if difference > 0 else 'less'}"
    cell = f"a cell of {parameters.voxel_size_mm:g} mm"
    return [f"the surface of {name} encloses {much} than its label, which has parts below {cell}"]


def enclosed_volume_mm3(mesh: Mesh) -> float:
    """Return the volume that a closed outward surface encloses, by the divergence theorem."""
    a, b, c = mesh.vertices_patient_mm[mesh.triangles].astype(float).transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def _surface(
    mask: Bool[np.ndarray, "i j k"],
    patient_from_index: Float[np.ndarray, "4 4"],
    parameters: BuildSurfacesParameters,
) -> Mesh | None:
    from skimage.measure import marching_cubes

    if not mask.any():
        return None
    share, patient_from_cell = resample_mask(mask, patient_from_index, parameters.voxel_size_mm)
    if share.max() <= HALF:
        return None
    vertices, triangles, _, _ = marching_cubes(share, HALF, allow_degenerate=False)
    vertices = transform_points(patient_from_cell, vertices.astype(np.float64))
    triangles = _outward(vertices, triangles)
    vertices = smooth_surface(vertices, triangles, parameters.smoothing_steps)
    vertices, triangles = _decimated(vertices, triangles, parameters.triangles)
    return Mesh(vertices.astype(np.float32), triangles.astype(np.int32))


def _outward(vertices: Vertices, triangles: Triangles) -> Triangles:
    """Wind triangles counter-clockwise seen from outside, that is with positive volume inside.

    Marching cubes winds bright objects inward, and a left-handed grid turns that round.
    """
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    signed_volume = np.einsum("ni,ni->", a, np.cross(b, c)) / 6
    return triangles if signed_volume > 0 else triangles[:, ::-1]


def _decimated(vertices: Vertices, triangles: Triangles, wanted: int) -> tuple[Vertices, Triangles]:
    """Collapse edges down to the wanted triangles, or to as few as stay closed.

    Collapsing does not check that the surface stays closed, so the result is checked; twice as
    many triangles are tried until they are as many as there were.
    """
    import open3d

    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(vertices),
        open3d.utility.Vector3iVector(np.ascontiguousarray(triangles, np.int32)),
    )
    while wanted < len(triangles):
        smaller = mesh.simplify_quadric_decimation(wanted)
        if _is_closed(np.asarray(smaller.triangles)):
            return np.asarray(smaller.vertices), np.asarray(smaller.triangles)
        wanted *= 2
    return vertices, triangles


def _is_closed(triangles: Triangles) -> bool:
    """Return whether each edge is used once in each direction: no hole, no sheet joined to it."""
    edges = np.concatenate([triangles[:, pair] for pair in ((0, 1), (1, 2), (2, 0))])
    forth = edges[:, 0].astype(np.int64) << 32 | edges[:, 1]
    back = edges[:, 1].astype(np.int64) << 32 | edges[:, 0]
    unique = np.unique(forth)
    return len(unique) == len(forth) > 0 and np.array_equal(unique, np.unique(back))
