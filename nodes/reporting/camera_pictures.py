"""What the camera at a robot's tip sees, as an endoscope's headlight shows it: a drawing."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, UInt8

from nodes.geometry.camera_views import render_depth
from nodes.geometry.grids import Volume
from nodes.geometry.meshes import Surfaces

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

Colours = UInt8[np.ndarray, "h w 3"]

WALL = (214, 142, 122)
TISSUES = {
    "left_lung": (196, 112, 124),
    "right_lung": (196, 112, 124),
    "lungs": (196, 112, 124),
    "collapsed_lung": (196, 112, 124),
    "bone": (226, 196, 164),
    "airway": (206, 150, 150),
}
"""Red, green, blue of the wall of the chest, and of what else lies behind the cavity's surface."""

GOAL = (255, 40, 190)
"""Of the goal's ring; no tissue has it."""

RING_RADIUS, RING_WIDTH = 0.09, 0.02
"""Radius of the goal's ring and half the width of its line; the circle has radius 1."""


@dataclass(frozen=True)
class Tissues:
    """What lies behind the cavity's surface, to be asked for the nearest organ.

    Parameters
    ----------
    tree : of points on all organs' surfaces, patient LPS mm.
    colours : (n, 3) of each one's organ.
    reach_mm : how near an organ must be.
    """

    tree: "cKDTree"
    colours: UInt8[np.ndarray, "n 3"]
    reach_mm: float


def gather_tissues(surfaces: Surfaces, reach_mm: float) -> Tissues:
    """Return the organs that have a colour of their own, as points near one another.

    Parameters
    ----------
    reach_mm : how near an organ must be to give its colour.
    """
    from scipy.spatial import cKDTree
    from trimesh.remesh import subdivide_to_size

    points, colours = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for name, mesh in surfaces.meshes:
        if name in TISSUES and len(mesh.triangles):
            dense, _ = subdivide_to_size(mesh.vertices_patient_mm, mesh.triangles, reach_mm)
            points.append(dense)
            colours.append(np.tile(TISSUES[name], (len(dense), 1)))
    return Tissues(
        cKDTree(np.concatenate(points)), np.concatenate(colours).astype(np.uint8), reach_mm
    )


def draw_view(
    distance_field: Volume,
    tissues: Tissues,
    patient_from_camera: Float[np.ndarray, "4 4"],
    field_of_view_deg: float,
    goals_patient_mm: Float[np.ndarray, "n 3"],
    pixels: int,
    near_mm: float,
) -> Colours:
    """Return what a camera sees, lit by a lamp at its own place.

    Light falls off with the square of the depth and with the cosine between the surface's normal
    and the ray; exposure is set so that the brightest hundredth is white.

    Parameters
    ----------
    distance_field : smooth, mm, positive in free space.
    field_of_view_deg : full angle, degrees; the circle in the picture.
    goals_patient_mm : where rings are drawn if the cone has them.
    near_mm : depth at which light has fallen to a half.
    """
    depth, normals, points = render_depth(
        distance_field, patient_from_camera, field_of_view_deg, pixels
    )
    seen = np.isfinite(depth)
    rays = points - patient_from_camera[:3, 3]
    rays /= np.maximum(np.linalg.norm(rays, axis=-1, keepdims=True), 1e-9)
    cosines = np.clip(-np.einsum("hwi,hwi->hw", normals, rays), 0, 1)
    light = np.where(seen, cosines / (1 + (depth / near_mm) ** 2), 0)
    white = np.percentile(light[seen], 99) if seen.any() else 1.0
    light = np.sqrt(np.clip(light / max(white, 1e-9), 0, 1))
    picture = colour_tissue(points, seen, tissues) * light[..., None]
    inside = is_in_view(patient_from_camera, field_of_view_deg, goals_patient_mm)
    places = place_goals(patient_from_camera, field_of_view_deg, goals_patient_mm[inside])
    return draw_rings(np.rint(picture).astype(np.uint8), places)


def colour_tissue(
    points_mm: Float[np.ndarray, "h w 3"], seen: Bool[np.ndarray, "h w"], tissues: Tissues
) -> Float[np.ndarray, "h w 3"]:
    """Return the colour of what lies where rays end; the chest's wall where no organ is near."""
    colours = np.broadcast_to(np.array(WALL, float), points_mm.shape).copy()
    if tissues.tree.n and seen.any():
        distances, nearest = tissues.tree.query(
            points_mm[seen], distance_upper_bound=tissues.reach_mm
        )
        found = np.isfinite(distances)
        inside = colours[seen]
        inside[found] = tissues.colours[nearest[found]]
        colours[seen] = inside
    return colours


def place_goals(
    patient_from_camera: Float[np.ndarray, "4 4"],
    field_of_view_deg: float,
    points_patient_mm: Float[np.ndarray, "n 3"],
) -> Float[np.ndarray, "n 2"]:
    """Return where points are in the picture: right and down from its middle, 1 at the circle.

    The picture is equidistant, as `render_depth` makes it.
    """
    across, angles = split_ways(patient_from_camera, points_patient_mm)
    lengths = np.maximum(np.linalg.norm(across, axis=1), 1e-12)
    return across * (angles / np.radians(field_of_view_deg / 2) / lengths)[:, None]


def is_in_view(
    patient_from_camera: Float[np.ndarray, "4 4"],
    field_of_view_deg: float,
    points_patient_mm: Float[np.ndarray, "n 3"],
) -> Bool[np.ndarray, "n"]:
    """Return which points are within the camera's cone, whether or not something hides them."""
    _, angles = split_ways(patient_from_camera, points_patient_mm)
    return angles <= np.radians(field_of_view_deg / 2)


def split_ways(
    patient_from_camera: Float[np.ndarray, "4 4"], points_patient_mm: Float[np.ndarray, "n 3"]
) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, "n"]]:
    """Return how far points are to the right and down, mm, and their angles from the view, rad."""
    ways = (points_patient_mm - patient_from_camera[:3, 3]) @ patient_from_camera[:3, :3]
    return ways[:, :2], np.arctan2(np.linalg.norm(ways[:, :2], axis=1), ways[:, 2])


def draw_rings(picture: Colours, places: Float[np.ndarray, "m 2"]) -> Colours:
    """Return the picture with a ring about each place."""
    side = picture.shape[0]
    middles = (2 * np.arange(side) + 1) / side - 1
    x, y = np.meshgrid(middles, middles)
    drawn = picture.copy()
    for place in places:
        away = np.abs(np.hypot(x - place[0], y - place[1]) - RING_RADIUS)
        drawn[away < RING_WIDTH] = GOAL
    return drawn
