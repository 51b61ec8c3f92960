"""Marks in a 3-D view as small closed meshes: balls at points, arrows and needles along lines."""

import numpy as np
from jaxtyping import Float, Int

from nodes.geometry.meshes import Mesh

SIDES = 8
"""Corners of a round mark; more is not seen at the size of a mark."""

HEAD_LENGTH, HEAD_RADIUS = 5.0, 2.5
"""Length and radius of an arrow's head, in radii of its shaft."""


def make_ball(centre_mm: Float[np.ndarray, "3"], radius_mm: float) -> Mesh:
    """Return a ball as a profile from pole to pole, turned about z."""
    polar = np.linspace(0, np.pi, SIDES // 2 + 1)
    profile = np.stack([radius_mm * np.sin(polar), -radius_mm * np.cos(polar)], axis=1)
    return turn_profile(centre_mm, np.array([0.0, 0.0, 1.0]), profile)


def make_needle(
    start_mm: Float[np.ndarray, "3"], end_mm: Float[np.ndarray, "3"], radius_mm: float
) -> Mesh:
    """Return a needle from start to end, pointed at its end."""
    length = float(np.linalg.norm(end_mm - start_mm))
    tip = max(length - 2 * radius_mm, length / 2)
    profile = np.array([[0, 0], [radius_mm, 0], [radius_mm, tip], [0, length]], float)
    return turn_profile(start_mm, end_mm - start_mm, profile)


def make_arrow(
    start_mm: Float[np.ndarray, "3"],
    direction: Float[np.ndarray, "3"],
    length_mm: float,
    radius_mm: float,
) -> Mesh:
    """Return an arrow of that length from start along direction."""
    neck = max(length_mm - HEAD_LENGTH * radius_mm, length_mm / 2)
    profile = [[0, 0], [1, 0], [1, neck], [HEAD_RADIUS, neck], [0, length_mm]]
    return turn_profile(start_mm, direction, np.array(profile) * [radius_mm, 1])


def turn_profile(
    start_mm: Float[np.ndarray, "3"],
    direction: Float[np.ndarray, "3"],
    profile_mm: Float[np.ndarray, "p 2"],
) -> Mesh:
    """Return the solid that a profile sweeps about a line, wound outward.

    Parameters
    ----------
    start_mm, direction : the line; direction of any length but 0, else +z.
    profile_mm : (p, 2) radius and height along the line, from bottom to top.
    """
    frame = frame_along(direction)
    turns = np.arange(SIDES) * 2 * np.pi / SIDES
    round_ = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    rings = profile_mm[:, None, :1] * round_
    heights = np.broadcast_to(profile_mm[:, None, 1:], (*rings.shape[:2], 1))
    points = np.concatenate([rings, heights], axis=2).reshape(-1, 3) @ frame.T + start_mm
    return Mesh(points.astype(np.float32), join_rings(len(profile_mm)))


def sweep_tube(
    points_mm: Float[np.ndarray, "n 3"], tangents: Float[np.ndarray, "n 3"], radius_mm: float
) -> Mesh:
    """Return the closed tube of that radius about a curve.

    Parameters
    ----------
    points_mm, tangents : (n, 3) along the curve, n > 1; the frame is carried along it with the
        least turn, so that no facet twists.
    """
    turns = np.arange(SIDES) * 2 * np.pi / SIDES
    frame, rings = frame_along(tangents[0]), []
    for point, tangent in zip(points_mm, tangents, strict=True):
        frame = carry_frame(frame, tangent)
        rings.append(
            point
            + radius_mm
            * (np.cos(turns)[:, None] * frame[:, 0] + np.sin(turns)[:, None] * frame[:, 1])
        )
    ends = [np.broadcast_to(points_mm[end], (SIDES, 3)) for end in (0, -1)]
    vertices = np.concatenate([ends[0], *rings, ends[1]])
    return Mesh(vertices.astype(np.float32), join_rings(len(rings) + 2))


def sweep_line(points_mm: Float[np.ndarray, "n 3"], radius_mm: float) -> Mesh:
    """Return the closed tube about a line through points; nothing where all points are one."""
    steps = np.linalg.norm(np.diff(points_mm, axis=0), axis=1)
    points = points_mm[np.concatenate([[True], steps > 0])]
    if len(points) < 2:
        return Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    tangents = np.gradient(points, axis=0)
    lengths = np.linalg.norm(tangents, axis=1, keepdims=True)
    forward = np.diff(points, axis=0, append=2 * points[-1:] - points[-2:-1])
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    along = np.where(lengths > 1e-9, tangents / np.maximum(lengths, 1e-9), forward)
    return sweep_tube(points, along, radius_mm)


def carry_frame(
    frame: Float[np.ndarray, "3 3"], tangent: Float[np.ndarray, "3"]
) -> Float[np.ndarray, "3 3"]:
    """Return the frame turned so that its third axis is `tangent`, its first turned least."""
    across = frame[:, 0] - tangent * (tangent @ frame[:, 0])
    if not np.linalg.norm(across) > 1e-6:  # the curve turned by a right angle at once
        return frame_along(tangent)
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(tangent, across), tangent], axis=1)


def frame_along(direction: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """Return a right-handed frame as columns whose third axis runs along `direction`."""
    length = np.linalg.norm(direction)
    along = direction / length if length > 0 else np.array([0.0, 0.0, 1.0])
    across = np.cross(np.eye(3)[np.abs(along).argmin()], along)
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(along, across), along], axis=1)


def join_rings(rings: int) -> Int[np.ndarray, "t 3"]:
    """Return two triangles for each pair of neighbours on neighbouring rings."""
    here = np.arange(SIDES)
    after = (here + 1) % SIDES
    first = np.concatenate(
        [
            np.stack([here, after, after + SIDES], axis=1),
            np.stack([here, after + SIDES, here + SIDES], axis=1),
        ]
    )
    steps = np.arange(rings - 1)[:, None, None] * SIDES
    return (first + steps).reshape(-1, 3).astype(np.int32)


def join_meshes(meshes: tuple[Mesh, ...]) -> Mesh:
    """Return several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices_patient_mm) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices_patient_mm for mesh in meshes]),
        np.concatenate(
            [mesh.triangles + start for mesh, start in zip(meshes, starts[:-1], strict=True)]
        ).astype(np.int32),
    )
