"""Measures of closed triangle surfaces that wind outward."""

import numpy as np
from jaxtyping import Float, Int

from nodes.geometry.meshes import Mesh


def enclosed_volume_mm3(mesh: Mesh) -> float:
    """Return the volume that a closed outward surface encloses, by the divergence theorem."""
    a, b, c = _corners(mesh)
    # Seen from a corner of its own the sum keeps its digits far from the origin.
    a, b, c = a - a[:1], b - a[:1], c - a[:1]
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def surface_area_mm2(mesh: Mesh) -> float:
    """Return the sum of the triangles' areas."""
    a, b, c = _corners(mesh)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def triangle_normals(
    vertices: Float[np.ndarray, "_ 3"], triangles: Int[np.ndarray, "t 3"]
) -> Float[np.ndarray, "t 3"]:
    """Return each triangle's outward normal, as long as its area; degenerate ones have none."""
    a, b, c = vertices[triangles].astype(float).transpose(1, 0, 2)
    return np.cross(b - a, c - a) / 2


def _corners(mesh: Mesh) -> Float[np.ndarray, "3 t 3"]:
    return mesh.vertices_patient_mm[mesh.triangles].astype(float).transpose(1, 0, 2)
