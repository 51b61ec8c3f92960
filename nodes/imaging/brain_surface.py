"""A closed surface that grows from the middle of the head until it lies on the brain.

Forces, names and constants are those of [Smith2002], Sec. "The main iterated loop".
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

Points = Float[np.ndarray, "n 3"]
Voxels = Float32[np.ndarray, "i j k"]

SUBDIVISIONS = 4  # of an icosahedron: 2562 vertices, about 4 mm apart on a brain
START_SHARE = 0.5  # radius of the first sphere, of the head's
TANGENTIAL_SHARE = 0.5  # of the way to the neighbours' mean that a vertex slides
SMOOTHEST_MM, SHARPEST_MM = 10.0, 10 / 3  # radii of curvature between which smoothing sets in
INTENSITY_SHARE = 0.05  # of the mean edge's length that a vertex moves along its normal
DARKEST_WITHIN_MM, BRIGHTEST_WITHIN_MM = 20.0, 10.0  # depths at which the surface looks inward
STEP_MM = 1.0  # between those looks


class Levels(NamedTuple):
    """Intensities to go by: t2, t, tm and t98 of [Smith2002]."""

    lowest: float
    background: float
    brain: float
    highest: float


class Wiring(NamedTuple):
    """What does not change while the vertices move."""

    triangles: Int[np.ndarray, "t 3"]
    edges: Int[np.ndarray, "e 2"]
    neighbours: object
    """(n, n) sparse; each row averages the neighbours of one vertex."""


def grow_brain_surface(
    voxels: Voxels,
    voxel_size_mm: float,
    centre_mm: Float[np.ndarray, "3"],
    radius_mm: float,
    levels: Levels,
    threshold: float,
    steps: int,
) -> tuple[Points, Int[np.ndarray, "t 3"]]:
    """Grow the surface.

    Parameters
    ----------
    voxels : (i, j, k) on cubic voxels.
    voxel_size_mm : their edge.
    centre_mm : middle of the head, mm from the first voxel's centre.
    radius_mm : of a ball as large as the head.
    levels : intensities to go by.
    threshold : b_t, share of the local brightness below which it is no brain; 0 to 1.
    steps : number of small moves.

    Returns
    -------
    vertices : (n, 3) mm from the first voxel's centre.
    triangles : (t, 3) vertex indices.
    """
    ball, wiring = _sphere()
    padded = np.pad(voxels, 1, constant_values=levels.lowest)  # beyond the image is air
    vertices = centre_mm + START_SHARE * radius_mm * ball
    for _ in range(steps):
        normals = _normals(vertices, wiring.triangles)
        ends = vertices[wiring.edges]
        edge = float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).mean())
        brightness = _brightness(padded, voxel_size_mm, vertices, normals, levels, threshold)
        push = (INTENSITY_SHARE * edge * brightness)[:, None] * normals
        vertices = vertices + _smoothing(vertices, normals, edge, wiring) + push
    return vertices, wiring.triangles


def _sphere() -> tuple[Points, Wiring]:
    import trimesh
    from scipy import sparse

    ball = trimesh.creation.icosphere(subdivisions=SUBDIVISIONS)
    edges = np.array(ball.edges_unique)
    ones = np.ones(2 * len(edges))
    both = np.concatenate([edges, edges[:, ::-1]])
    neighbours = sparse.csr_array((ones, (both[:, 0], both[:, 1])))
    degree = np.asarray(neighbours.sum(axis=1)).ravel()
    mean = sparse.csr_array(sparse.diags_array(1 / degree) @ neighbours)
    return np.array(ball.vertices), Wiring(np.array(ball.faces), edges, mean)


def _normals(vertices: Points, triangles: Int[np.ndarray, "t 3"]) -> Points:
    """Return outward unit normals: of all triangles at a vertex, weighted by area."""
    corners = vertices[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    ends = triangles.ravel(order="F")
    sums = [np.bincount(ends, np.tile(across[:, axis], 3), len(vertices)) for axis in range(3)]
    normals = np.stack(sums, axis=1)
    return normals / (np.linalg.norm(normals, axis=1, keepdims=True) + 1e-12)


def _smoothing(vertices: Points, normals: Points, edge: float, wiring: Wiring) -> Points:
    """Return u1 + u2: slide among the neighbours, and give in to sharp curvature only."""
    offset = wiring.neighbours @ vertices - vertices
    along = (offset * normals).sum(axis=1)
    inward = along[:, None] * normals
    curvature = 2 * abs(along) / edge**2
    middle = (1 / SHARPEST_MM + 1 / SMOOTHEST_MM) / 2
    slope = 6 / (1 / SHARPEST_MM - 1 / SMOOTHEST_MM)
    share = (1 + np.tanh(slope * (curvature - middle))) / 2
    return TANGENTIAL_SHARE * (offset - inward) + share[:, None] * inward


def _brightness(
    padded: Voxels,
    voxel_size_mm: float,
    vertices: Points,
    normals: Points,
    levels: Levels,
    threshold: float,
) -> Float[np.ndarray, " n"]:
    """Return f3: above 0 where all below the surface is bright enough for brain."""
    depths = np.arange(0, DARKEST_WITHIN_MM + STEP_MM / 2, STEP_MM)
    values = _looks_inward(padded, vertices / voxel_size_mm + 1, normals, depths / voxel_size_mm)
    near = values[:, depths <= BRIGHTEST_WITHIN_MM]
    darkest = np.clip(values.min(axis=1), levels.lowest, levels.brain)
    brightest = np.clip(near.max(axis=1), levels.background, levels.brain)
    span = brightest - levels.lowest
    return 2 * (darkest - levels.lowest - threshold * span) / span


def _looks_inward(
    padded: Voxels, places: Points, normals: Points, depths: Float[np.ndarray, " d"]
) -> Float[np.ndarray, "n d"]:
    """Return the nearest voxels' values at these depths; all in voxels of the padded image."""
    steps = depths.astype(np.float32)
    flat = np.zeros((len(places), len(depths)), np.int64)
    for axis, count in enumerate(padded.shape):
        start = places[:, axis, None].astype(np.float32)
        index = np.rint(start - normals[:, axis, None].astype(np.float32) * steps)
        flat = flat * count + np.clip(index, 0, count - 1).astype(np.int32)
    return padded.ravel()[flat].astype(float)


def fill_surface(
    vertices: Points,
    triangles: Int[np.ndarray, "t 3"],
    shape: tuple[int, ...],
    voxel_size_mm: float,
) -> Bool[np.ndarray, "i j k"]:
    """Return the voxels that a closed surface passes through or encloses.

    A fold of the surface through itself stays inside, unlike where crossings are counted.
    """
    from scipy import ndimage

    corners = vertices[triangles] / voxel_size_mm
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()
    parts = int(np.ceil(longest / 0.4))  # samples closer than half a voxel leave no gap
    u, v = np.indices((parts + 1, parts + 1)).reshape(2, -1) / parts
    u, v = u[u + v < 1 + 1e-9], v[u + v < 1 + 1e-9]
    weights = np.stack([1 - u - v, u, v], axis=1)
    samples = np.rint(weights @ corners).astype(np.intp).reshape(-1, 3)
    # What lies beyond the image is moved to a rim around it, where it closes the surface.
    samples = np.clip(samples + 1, 0, np.array(shape) + 1)
    mask = np.zeros(np.array(shape) + 2, bool)
    mask[tuple(samples.T)] = True
    return ndimage.binary_fill_holes(mask)[1:-1, 1:-1, 1:-1]
