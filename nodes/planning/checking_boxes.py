"""Distances from points to the boxes of occupied cells, by a k-d tree of their centres."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.errors import BadInput
from nodes.geometry.grids import spacing_mm

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

FEW, MANY = 12, 64  # nearest centres that are looked at, first and where these leave a doubt
RIGHT_ANGLE = 1e-6  # what the axes of cells may be off from orthogonal
Points = Float[np.ndarray, "n 3"]


class Boxes(NamedTuple):
    """Occupied cells, in axes along the grid, mm, in which cell c is centred at c * spacing.

    Parameters
    ----------
    occupied : (i, j, k) of all cells.
    outside : whether what lies beyond the grid is occupied.
    centres : (b, 3) of occupied cells next to others, to which all ways from outside lead.
    tree : of those centres; None without any.
    half : (3,) half the edges of a cell.
    away : (i + 2, j + 2, k + 2) mm, from the centre of each cell, and of one more around the grid,
        to the nearest centre of an occupied one.
    grid_from_patient : (4, 4).
    """

    occupied: np.ndarray
    outside: bool
    centres: np.ndarray
    tree: "cKDTree | None"
    half: np.ndarray
    away: np.ndarray
    grid_from_patient: np.ndarray


def make_boxes(
    occupied: Bool[np.ndarray, "i j k"],
    patient_from_index: Float[np.ndarray, "4 4"],
    outside: bool,
) -> Boxes:
    """Return the cells that something may touch."""
    from scipy.ndimage import binary_dilation, distance_transform_edt
    from scipy.spatial import cKDTree

    spacing = spacing_mm(patient_from_index)
    axes = patient_from_index[:3, :3] / spacing
    if abs(axes.T @ axes - np.eye(3)).max() > RIGHT_ANGLE:
        raise BadInput(
            f"a grid with axes {axes.T.round(6).tolist()}",
            "the axes of cells are orthogonal",
            "straighten the image first",
        )
    padded = np.pad(occupied, 1, constant_values=outside)
    # A way to an occupied cell ends at the nearest that touches an open cell, if by a corner.
    border = padded & binary_dilation(~padded, np.ones((3, 3, 3), bool))
    centres = (np.argwhere(border) - 1.0) * spacing
    tree = cKDTree(centres) if len(centres) else None
    away = np.full(padded.shape, np.inf)
    if padded.any():
        away = distance_transform_edt(~padded, sampling=spacing)
    to_grid = np.diag([*spacing, 1.0]) @ np.linalg.inv(patient_from_index)
    return Boxes(occupied, outside, centres, tree, spacing / 2, away, to_grid)


def bound_distances(points: Points, boxes: Boxes) -> tuple[np.ndarray, np.ndarray]:
    """Return least and largest distances, mm, that points in patient mm may have to the nearest
    occupied cell; 0 within one."""
    own, within = _to_grid(points, boxes), _are_within(_to_grid(points, boxes), boxes)
    cells = np.clip(_to_cells(own, boxes), -1, np.array(boxes.occupied.shape))
    # From the cell's centre to the point the distance changes by no more than the way.
    aside = np.linalg.norm(own - 2 * boxes.half * cells, axis=1)
    nearest = boxes.away[tuple((cells + 1).T)]
    low = np.maximum(nearest - aside - np.linalg.norm(boxes.half), 0.0)
    return np.where(within, 0.0, low), np.where(within, 0.0, nearest + aside)


def measure_distances(points: Points, boxes: Boxes) -> Float[np.ndarray, "n"]:
    """Return the distance of points in patient mm to the nearest occupied cell, mm; 0 within one.

    Exact unless more than `MANY` centres lie about as near as the nearest; then less.
    """
    own = _to_grid(points, boxes)
    found, certain = _measure(own, FEW, boxes)
    doubtful = np.flatnonzero(found > certain)
    if len(doubtful):
        again, most = _measure(own[doubtful], MANY, boxes)
        found[doubtful] = np.minimum(again, most)
    return np.where(_are_within(own, boxes), 0.0, found)


def _measure(own: Points, count: int, boxes: Boxes) -> tuple[np.ndarray, np.ndarray]:
    """Return distances to the boxes of the nearest centres, and up to which they are certain: no
    other box is nearer."""
    if boxes.tree is None:
        return np.full(len(own), np.inf), np.full(len(own), np.inf)
    count = min(count, len(boxes.centres))
    away, which = boxes.tree.query(own, np.arange(1, count + 1))
    gaps = np.maximum(abs(own[:, None] - boxes.centres[which]) - boxes.half, 0.0)
    certain = np.maximum(away[:, -1] - np.linalg.norm(boxes.half), 0.0)
    if count == len(boxes.centres):
        certain = np.full(len(own), np.inf)
    return np.sqrt((gaps**2).sum(axis=2).min(axis=1)), certain


def _to_grid(points: Points, boxes: Boxes) -> Points:
    return points @ boxes.grid_from_patient[:3, :3].T + boxes.grid_from_patient[:3, 3]


def _are_within(own: Points, boxes: Boxes) -> Bool[np.ndarray, "n"]:
    cells = _to_cells(own, boxes)
    on_grid = ((cells >= 0) & (cells < boxes.occupied.shape)).all(axis=1)
    cells[~on_grid] = 0
    return np.where(on_grid, boxes.occupied[tuple(cells.T)], boxes.outside)


def _to_cells(own: Points, boxes: Boxes) -> Int[np.ndarray, "n 3"]:
    return np.floor(own / (2 * boxes.half) + 0.5).astype(int)
