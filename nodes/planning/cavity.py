"""Grids as collision checking takes them: where needles may be, and what their sheaths avoid."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Float32

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume, spacing_mm

if TYPE_CHECKING:
    from nodes.kernels.crisp_collision import Space

RIGHT_ANGLE = 1e-6  # cosine up to which axes of a grid count as orthogonal
ROUNDING = 1e-6  # of distances in single precision, as a share of them


def make_cavity(occupancy_grid: LabelMap, distance_field: Volume) -> "Space":
    """Return the cells that are free, and how much room there is at their centres.

    Raises
    ------
    BadInput : if the two are not on one grid, or the grid's axes are not orthogonal.
    """
    free = occupancy_grid.mask("free")
    same = np.array_equal(occupancy_grid.patient_from_index, distance_field.patient_from_index)
    if distance_field.voxels.shape != free.shape or not same:
        raise BadInput(
            f"a distance field of {distance_field.voxels.shape} cells and an occupancy grid of"
            f" {free.shape}",
            "both are on the same cells at the same place",
            "measure the distances of this occupancy grid",
        )
    room = np.where(free, distance_field.voxels, np.float32(0))
    return _make_space(free, room, occupancy_grid.patient_from_index)


def make_wall(label_map: LabelMap, names: tuple[str, ...]) -> "Space":
    """Return the cells that hold none of the labels `names`; no cells if there are no names.

    Raises
    ------
    BadInput : if the map has no such label.
    """
    for name in names:
        if name not in label_map.names:
            raise BadInput(
                f"sheath_avoids: {name}",
                f"the label map has the labels {', '.join(label_map.names)}",
                "set sheath_avoids to some of them, or to none",
            )
    if not names:
        return _make_space(np.zeros((0, 0, 0), bool), np.zeros((0, 0, 0), np.float32), np.eye(4))
    taken = np.isin(label_map.voxels, [label_map.names.index(name) + 1 for name in names])
    room = _measure_room(taken, spacing_mm(label_map.patient_from_index))
    return _make_space(~taken, room, label_map.patient_from_index)


def _measure_room(
    taken: Bool[np.ndarray, "i j k"], spacing: Float[np.ndarray, "3"]
) -> Float32[np.ndarray, "i j k"]:
    """Return each cell centre's distance to the nearest box that is taken, mm; 0 in those."""
    from nodes.kernels.distance_transform import sweep

    squared = np.empty(taken.shape, np.float32)
    for axis in (2, 1, 0):
        shape = (int(np.prod(taken.shape[:axis])), taken.shape[axis], -1)
        lines, cells = squared.reshape(shape), taken.reshape(shape)
        sweep(lines, cells, float(spacing[axis]), axis == 2, 0, 1)
    return np.where(taken, np.float32(0), np.sqrt(squared))


def _make_space(
    free: Bool[np.ndarray, "i j k"],
    room: Float32[np.ndarray, "i j k"],
    patient_from_index: Float[np.ndarray, "4 4"],
) -> "Space":
    from nodes.kernels.crisp_collision import Space

    spacing = spacing_mm(patient_from_index)
    axes = patient_from_index[:3, :3] / spacing
    if np.abs(axes.T @ axes - np.eye(3)).max() > RIGHT_ANGLE:
        raise BadInput(
            f"a grid with axes {axes.T.round(6).tolist()}",
            "the axes of cells are orthogonal",
            "straighten the image first",
        )
    return Space(
        np.ascontiguousarray(free, np.uint8),
        np.ascontiguousarray(room * np.float32(1 - ROUNDING)),
        spacing,
        np.ascontiguousarray(np.linalg.inv(patient_from_index)[:3]),
    )
