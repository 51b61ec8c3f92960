"""Small grids and how far needles are from their boxes, found without any kernel of theirs."""

import numpy as np
from scipy.spatial.transform import Rotation

from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.origin import Origin

MADE = Origin("made for a test", simulated=True)


def turned_affine(rng, spacing, turned=True):
    """Return patient_from_index of a grid that lies somewhere."""
    affine = np.eye(4)
    turn = Rotation.random(random_state=rng).as_matrix() if turned else np.eye(3)
    affine[:3, :3] = turn * spacing
    affine[:3, 3] = rng.uniform(-50, 50, 3)
    return affine


def grid_of(free, affine):
    """Return an occupancy grid and its distance field, each distance found box by box."""
    spacing = np.linalg.norm(affine[:3, :3], axis=0)
    corners = np.argwhere(np.ones(free.shape, bool)) * spacing
    distances = np.array([_clearance(place, free, spacing) for place in corners])
    grid = LabelMap(free.astype(np.uint8), affine, ("free",), MADE)
    return grid, Volume(distances.reshape(free.shape).astype(np.float32), affine, "mm", MADE)


def _clearance(place, free, spacing):
    padded = np.pad(free, 1)
    boxes = (np.argwhere(~padded) - 1) * spacing
    away = np.maximum(abs(place - boxes) - spacing / 2, 0)
    return np.linalg.norm(away, axis=1).min()


def capsule_distance(start, end, taken, affine):
    """Return the least distance between a segment and boxes of cells `taken`, patient mm, by
    golden sections of the way, which is enough since the distance to a box is convex."""
    spacing = np.linalg.norm(affine[:3, :3], axis=0)
    to_grid = np.linalg.inv(affine)
    a, b = ((to_grid[:3, :3] @ p + to_grid[:3, 3]) * spacing for p in (start, end))
    boxes = taken * spacing

    def away(share):
        places = a + share[:, None] * (b - a)
        return np.linalg.norm(np.maximum(abs(places - boxes) - spacing / 2, 0), axis=1)

    low, high = np.zeros(len(boxes)), np.ones(len(boxes))
    for _ in range(90):
        one, two = low + 0.382 * (high - low), low + 0.618 * (high - low)
        is_low = away(one) <= away(two)
        low, high = np.where(is_low, low, one), np.where(is_low, two, high)
    return away((low + high) / 2).min(initial=np.inf)


def taken_cells(free, around=0):
    """Return the cells that are not free, with a wall of so many cells beyond the grid."""
    return np.argwhere(~np.pad(free, around)) - around
