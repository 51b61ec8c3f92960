"""Fewer triangles for closed surfaces that stay closed and keep their volume."""

import numpy as np
from jaxtyping import Float, Int

from nodes.geometry.closed_surfaces import triangle_normals

Vertices = Float[np.ndarray, "_ 3"]
Triangles = Int[np.ndarray, "_ 3"]

# Shares of the wanted triangles that are tried, since collapsing may open a surface at one count
# and not at the next.
SHARES = (1.0, 0.995, 0.99)
ROUNDS = 3  # of moving to a volume; each is linear, so the error is squared every time


def decimate(vertices: Vertices, triangles: Triangles, wanted: int) -> tuple[Vertices, Triangles]:
    """Collapse edges by quadric error down to the wanted triangles, or to as few as stay closed
    [Garland1997].

    Collapsing does not check that the surface stays closed, so the result is checked; twice as many
    triangles are tried until they are as many as there were.
    """
    import open3d

    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(vertices),
        open3d.utility.Vector3iVector(np.ascontiguousarray(triangles, np.int32)),
    )
    while wanted < len(triangles):
        for share in SHARES:
            smaller = mesh.simplify_quadric_decimation(int(wanted * share))
            if is_closed(np.asarray(smaller.triangles)):
                return np.asarray(smaller.vertices), np.asarray(smaller.triangles)
        wanted *= 2
    return vertices, triangles


def is_closed(triangles: Triangles) -> bool:
    """Return whether each edge is used once in each direction: no hole, no sheet joined to it."""
    edges = np.concatenate([triangles[:, pair] for pair in ((0, 1), (1, 2), (2, 0))])
    forth = edges[:, 0].astype(np.int64) << 32 | edges[:, 1]
    back = edges[:, 1].astype(np.int64) << 32 | edges[:, 0]
    unique = np.unique(forth)
    return len(unique) == len(forth) > 0 and np.array_equal(unique, np.unique(back))


def move_to_volume(
    vertices: Vertices, triangles: Triangles, volume_mm3: float, most_mm: float
) -> Vertices:
    """Move all vertices along their normals by one distance, at most `most_mm`, so that the surface
    encloses a volume.

    The volume's derivative by a vertex is a third of the area vectors around it.
    """
    moved, total = vertices, 0.0
    for _ in range(ROUNDS):
        areas = triangle_normals(moved, triangles)
        slopes = np.stack([
            np.bincount(triangles.ravel(), np.repeat(areas[:, axis], 3), len(vertices)) / 3
            for axis in range(3)
        ], axis=1)  # fmt: skip
        lengths = np.linalg.norm(slopes, axis=1)
        volume = np.einsum("ij,ij->", moved - moved[0], slopes) / 3
        step = float(
            np.clip((volume_mm3 - volume) / lengths.sum(), -most_mm - total, most_mm - total)
        )
        moved = moved + step * slopes / np.maximum(lengths, 1e-12)[:, None]
        total += step
    return moved
