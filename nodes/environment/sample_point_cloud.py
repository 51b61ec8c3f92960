"""Surfaces as evenly spread points with outward normals."""

import numpy as np
from jaxtyping import Float, Int

from nodes.environment.parameters import SamplePointCloudParameters
from nodes.errors import BadInput
from nodes.geometry.closed_surfaces import triangle_normals
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.point_clouds import PointCloud

# Candidates lie so densely that each place of the surface has one within 2/9 of the spacing: the
# way from a small triangle's centre to its corners is at most 2/3 of its longest edge.
PIECES_PER_SPACING = 3


def sample_point_cloud(surfaces: Surfaces, parameters: SamplePointCloudParameters) -> PointCloud:
    """Spread points evenly over each surface, as planning in point clouds needs them [Kuntz2019].

    Places on the surface are taken in random order, each that has no taken one of its surface
    within the spacing. So two points of a surface are never nearer than the spacing, and each
    place of it has a point within 1.25 of the spacing: an obstacle as thin as that is not passed
    unseen.

    Parameters
    ----------
    surfaces : closed outward surfaces; flat triangles have no normal and are left out.
    parameters : spacing, seed.

    Returns
    -------
    Points of all surfaces in their order, each with its triangle's outward normal.

    Raises
    ------
    BadInput where there is no triangle.
    """
    from nodes.kernels.point_thinning import thin_points

    chance = np.random.default_rng(parameters.seed)
    points, normals, labels = [], [], []
    for label, (_, mesh) in enumerate(surfaces.meshes, start=1):
        places, triangle = _places(mesh, parameters.spacing_mm / PIECES_PER_SPACING)
        order = chance.permutation(len(places))
        places, triangle = places[order], triangle[order]
        kept = thin_points(places, parameters.spacing_mm)
        facing = triangle_normals(mesh.vertices_patient_mm, mesh.triangles[triangle[kept]])
        points.append(places[kept])
        normals.append(facing / np.linalg.norm(facing, axis=1, keepdims=True))
        labels.append(np.full(kept.sum(), label, np.uint8))
    if not sum(len(part) for part in points):
        raise BadInput(
            f"{len(surfaces.meshes)} surfaces without a triangle",
            "points are taken from triangles",
            "build surfaces of labels that are not empty",
        )
    names = tuple(name for name, _ in surfaces.meshes)
    return PointCloud(
        np.concatenate(points).astype(np.float32),
        np.concatenate(normals).astype(np.float32),
        np.concatenate(labels),
        names,
        surfaces.origin.with_notice(
            f"points lie {parameters.spacing_mm:g} mm or more apart on each surface"
        ),
    )


def _places(
    mesh: Mesh, longest_mm: float
) -> tuple[Float[np.ndarray, "n 3"], Int[np.ndarray, " n"]]:
    """Cut each triangle into equal ones with edges of at most `longest_mm`; return their centres,
    and of which triangle each is a part."""
    corners = mesh.vertices_patient_mm[mesh.triangles].astype(float)
    areas = np.linalg.norm(triangle_normals(mesh.vertices_patient_mm, mesh.triangles), axis=1)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0)
    pieces = np.where(areas > 0, np.maximum(np.ceil(longest / longest_mm), 1), 0).astype(int)
    points, triangles = [], []
    for count in np.unique(pieces[pieces > 0]):
        chosen = np.flatnonzero(pieces == count)
        weights = _centres(int(count))
        points.append(np.einsum("wc,tcx->twx", weights, corners[chosen]).reshape(-1, 3))
        triangles.append(np.repeat(chosen, len(weights)))
    if not points:
        return np.empty((0, 3)), np.empty(0, int)
    return np.concatenate(points), np.concatenate(triangles)


def _centres(count: int) -> Float[np.ndarray, "w 3"]:
    """Return the corner weights of the centres of count^2 equal parts of a triangle."""
    i, j = np.indices((count, count)).reshape(2, -1)
    upright = np.stack([i + 1 / 3, j + 1 / 3], axis=1)[i + j < count]
    turned = np.stack([i + 2 / 3, j + 2 / 3], axis=1)[i + j < count - 1]
    two = np.concatenate([upright, turned]) / count
    return np.column_stack([two, 1 - two.sum(axis=1)])
