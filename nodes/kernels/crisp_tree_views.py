"""Which cells of the goals a tree's nodes see first."""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.cell_rays import sees_cell
from nodes.kernels.crisp_options import INNER


class Sights(NamedTuple):
    """Cells to be seen.

    cells : (cell, 3) int64.
    unseen : (cell,) int64, those that no node has seen yet, up to `left`.
    left : (1,) int64.
    seeing : (cell,) int64 first node that sees each, or -1.
    squared_cosine : of half the field of view.
    camera, gaze : (3,) overwritten.
    """

    cells: np.ndarray
    unseen: np.ndarray
    left: np.ndarray
    seeing: np.ndarray
    squared_cosine: float
    camera: np.ndarray
    gaze: np.ndarray


@njit(**INNER)
def look_out(sights, task, tip, node):
    """Write a node as the first that sees whatever it sees of the cells that are unseen."""
    if sights.left[0] == 0:
        return
    for axis in range(3):
        sights.camera[axis] = tip[axis] * task.scale.unit + task.entry[axis]
        sights.gaze[axis] = tip[3 + axis]
    free, index_from_patient = task.cavity.free, task.cavity.index_from_patient
    left, kept = sights.left[0], 0
    for rank in range(left):
        cell = sights.unseen[rank]
        i, j, k = sights.cells[cell]
        if sees_cell(
            free, index_from_patient, sights.camera, sights.gaze, sights.squared_cosine, i, j, k
        ):
            sights.seeing[cell] = node
        else:
            sights.unseen[kept] = cell
            kept += 1
    sights.left[0] = kept
