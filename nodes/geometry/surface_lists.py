"""The cells of a surface in lists of neighbours that a free cell touches over the same face."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Int, Int32, UInt8

Cells = Int32[np.ndarray, "cell 3"]
Numbers = Int[np.ndarray, " n"]

if TYPE_CHECKING:
    from nodes.kernels.cell_lists import Lists

FACES = 6


def list_faces(
    cells: Cells,
    free: UInt8[np.ndarray, "i j k"],
    wanted: Numbers,
    size: int,
    part: tuple[int, int] = (0, 1),
) -> "Lists":
    """Return the lists of all free faces of the wanted cells.

    Parameters
    ----------
    cells : indices.
    free : 1 where the space is free; beyond the grid nothing is.
    wanted : numbers of cells.
    size : of the blocks, cells; a list has the cells of one block.
    part : (n, of): only the n-th of each `of` blocks.
    """
    chosen, padded = cells[wanted].astype(np.int64), np.pad(free, 1)
    blocks = _blocks(chosen, size)
    members, keys = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for face in range(FACES):
        beside = chosen + 1
        beside[:, face % 3] += 1 if face >= 3 else -1
        is_open = (padded[tuple(beside.T)] != 0) & (blocks % part[1] == part[0])
        members.append(wanted[is_open])
        keys.append(blocks[is_open] * FACES + face)
    return _gather(cells, np.concatenate(members), np.concatenate(keys))


def list_blocks(cells: Cells, size: int) -> "Lists":
    """Return the lists of all cells, one a block, whatever their faces."""
    return _gather(cells, np.arange(len(cells)), FACES * _blocks(cells.astype(np.int64), size))


def _blocks(cells: Int[np.ndarray, "n 3"], size: int) -> Numbers:
    places = cells // size
    return np.ravel_multi_index(tuple(places.T), tuple(places.max(axis=0, initial=0) + 1))


def _gather(cells: Cells, members: Numbers, keys: Numbers) -> "Lists":
    from nodes.kernels.cell_lists import Lists
    from nodes.kernels.cell_rays import FINE, HALF

    order = np.argsort(keys, kind="stable")
    members = members[order]
    lists, starts = np.unique(keys[order], return_index=True)
    centres = np.ascontiguousarray(cells[members].T) * FINE + HALF
    low, high = (
        edge.reduceat(centres, starts, axis=1).astype(float) if len(starts) else np.empty((3, 0))
        for edge in (np.minimum, np.maximum)
    )
    counts = np.diff(starts, append=len(members))
    boxes = (low + high) / 2, (high - low) / 2
    return Lists(members.astype(np.int32), centres, starts, counts, lists % FACES, *boxes)
