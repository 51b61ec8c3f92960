"""Whether the tips of needles lie in cells of the free part that they reach."""

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.environment.needle_space import NeedleSpace
from nodes.geometry.frames import transform_points

Points = Float[np.ndarray, "n 3"]

CELL_DIAGONAL = 3**0.5  # cells


def tips_in_cells(
    pleura: Points, direction: Points, space: NeedleSpace, depth_mm: float
) -> Bool[np.ndarray, " n"]:
    """Return which tips pass through no cells but those of the part.

    A cell is free where half of it is, so that up to one cell's diagonal behind the place where the
    labels become free a tip may still be in a boundary cell; its end may not.

    Parameters
    ----------
    pleura : where needles reach the part, mm along the grid's axes.
    direction : unit vectors along the same axes.
    space : around the part.
    depth_mm : length of the tips.
    """
    cell_mm = 1 / np.linalg.norm(space.cell_from_grid[:3, 0])
    first = min(CELL_DIAGONAL * cell_mm, depth_mm)
    starts, ends = (
        transform_points(space.cell_from_grid, pleura + way * direction)
        for way in (first, depth_mm)
    )
    cells = _cells_on_way(starts, ends)
    size = np.array(space.cells.shape)
    inside = ((cells >= 0) & (cells < size)).all(axis=-1)
    i, j, k = np.moveaxis(np.clip(cells, 0, size - 1), -1, 0)
    return (space.cells[i, j, k] & inside).all(axis=1)


def _cells_on_way(starts: Points, ends: Points) -> Int[np.ndarray, "n m 3"]:
    """Return all cells that each segment passes through, in order; some several times.

    A segment is cut where it leaves cells; the middle of each piece tells its cell.
    """
    way = ends - starts
    count = int(np.ceil(abs(way).max(initial=0))) + 1
    faces = np.floor(np.minimum(starts, ends) + 0.5) + 0.5
    faces = faces[..., None] + np.arange(count)
    with np.errstate(divide="ignore"):  # along an axis that the way does not follow, all are beyond
        leaves = (faces - starts[..., None]) / way[..., None]
    cuts = np.clip(leaves.reshape(len(starts), 3 * count), 0, 1)
    cuts = np.sort(np.pad(cuts, ((0, 0), (1, 1)), constant_values=(0, 1)), axis=1)
    middles = (cuts[:, 1:] + cuts[:, :-1]) / 2
    return np.rint(starts[:, None] + middles[..., None] * way[:, None]).astype(int)
