"""The part of a label map that needles through the wall can meet, as the needles see it."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, UInt8

from nodes.environment.distances import distance_to_faces
from nodes.environment.free_parts import boundary_of
from nodes.environment.parameters import FindEntryCorridorsParameters
from nodes.errors import BadInput
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap, spacing_mm
from nodes.geometry.masks import bounding_box

# What a voxel is to a needle; the kernel has the same numbers.
OUTSIDE, WALL, FREE, FORBIDDEN = 0, 1, 2, 3


class NeedleSpace(NamedTuple):
    """A box of voxels around one part of the free space, with the widest wall around it.

    kinds : what each voxel is to a needle.
    bone : voxels of bone.
    distance : of voxel centres to the nearest forbidden box, mm.
    spacing : of the voxels, mm.
    box : the part of the label map's grid.
    middle : of the whole body's extent, patient LPS mm.
    patient_from_grid : millimetres along the voxel axes from the first voxel of the box's centre,
        to patient LPS mm.
    part : name of the part.
    cells : cells of the part in the occupancy grid.
    cell_from_grid : the same millimetres to indices of these cells.
    """

    kinds: UInt8[np.ndarray, "i j k"]
    bone: Bool[np.ndarray, "i j k"]
    distance: Float32[np.ndarray, "i j k"]
    spacing: Float[np.ndarray, "3"]
    box: tuple[slice, slice, slice]
    middle: Float[np.ndarray, "3"]
    patient_from_grid: Float[np.ndarray, "4 4"]
    part: str
    cells: Bool[np.ndarray, "a b c"]
    cell_from_grid: Float[np.ndarray, "4 4"]


def cut_needle_space(
    label_map: LabelMap,
    occupancy_grid: LabelMap,
    part: str,
    parameters: FindEntryCorridorsParameters,
) -> NeedleSpace:
    """Cut out the voxels that a needle to a part can meet and say what each is to it.

    The labels that the grid was made free by are known by their place: more than half of each lies
    in cells of a free part. Free are these labels in cells of the wanted part or next to it; their
    other parts, and all labels that are neither free nor wall, are forbidden.

    Raises
    ------
    BadInput where a wall label is unknown, or the grids do not belong together.
    """
    kind_of = np.full(256, FORBIDDEN, np.uint8)
    kind_of[0] = OUTSIDE
    kind_of[_numbers(label_map, parameters.wall_labels)] = WALL
    cells = _cells_of_voxels(label_map, occupancy_grid)
    kind_of[_free_numbers(label_map, occupancy_grid, cells)] = FREE
    free = occupancy_grid.mask(part)
    near = np.pad(free | boundary_of(free, "corners"), 1)
    spacing = spacing_mm(label_map.patient_from_index)
    box = _box_around(near, cells, parameters.thickest_wall_mm, spacing)
    kinds = kind_of[label_map.voxels[box]]
    reached = near[np.ix_(*(c[side] for c, side in zip(cells, box, strict=True)))]
    kinds[(kinds == FREE) & ~reached] = FORBIDDEN
    is_bone = np.zeros(256, bool)
    known = tuple(name for name in parameters.bone_labels if name in label_map.names)
    is_bone[_numbers(label_map, known)] = True
    bone = is_bone[label_map.voxels[box]]
    patient_from_grid = label_map.patient_from_index.copy()
    patient_from_grid[:3, 3] += patient_from_grid[:3, :3] @ [side.start for side in box]
    patient_from_grid[:3, :3] /= spacing
    distance = distance_to_faces(kinds == FORBIDDEN, spacing)
    cell_from_grid = np.linalg.inv(occupancy_grid.patient_from_index) @ patient_from_grid
    return NeedleSpace(kinds, bone, distance, spacing, box, _middle(label_map), patient_from_grid,
                       part, free, cell_from_grid)  # fmt: skip


def _middle(label_map: LabelMap) -> Float[np.ndarray, "3"]:
    sides = bounding_box(label_map.voxels > 0)
    index = np.array([[(side.start + side.stop - 1) / 2 for side in sides]])
    return transform_points(label_map.patient_from_index, index)[0]


def _numbers(label_map: LabelMap, names: tuple[str, ...]) -> list[int]:
    for name in names:
        if name not in label_map.names:
            raise BadInput(
                f"label {name}",
                f"the label map has the labels {', '.join(label_map.names)}",
                "set wall_labels to some of them",
            )
    return [label_map.names.index(name) + 1 for name in names]


def _cells_of_voxels(label_map: LabelMap, occupancy_grid: LabelMap) -> list[Int[np.ndarray, " _"]]:
    """Return in which cell, of the grid padded by one, the voxels' centres lie, for each axis."""
    cell_from_index = (
        np.linalg.inv(occupancy_grid.patient_from_index) @ label_map.patient_from_index
    )
    scale = np.diag(cell_from_index)[:3]
    if not np.allclose(cell_from_index[:3, :3], np.diag(scale), atol=1e-6):
        raise _other_image("an occupancy grid whose axes are not those of the label map")
    return [
        _clipped(np.arange(count) * scale[axis] + cell_from_index[axis, 3], size + 2)
        for axis, (count, size) in enumerate(
            zip(label_map.voxels.shape, occupancy_grid.voxels.shape, strict=True)
        )
    ]


def _free_numbers(
    label_map: LabelMap, occupancy_grid: LabelMap, cells: list[Int[np.ndarray, " _"]]
) -> list[int]:
    """Return the labels of which more than half lies in free cells, and the one with most there,
    which may be so thin that most of it is lost in the cells."""
    obstacle = (occupancy_grid.voxels == 0) | occupancy_grid.mask("boundary")
    parts = np.pad(~obstacle, 1)
    inside = np.bincount(label_map.voxels[parts[np.ix_(*cells)]], minlength=256)
    inside[0] = 0
    if not inside.any():
        raise _other_image("an occupancy grid in whose free cells nothing is labelled")
    numbers = range(1, len(label_map.names) + 1)
    most = int(inside.argmax())
    return [
        n for n in numbers if n == most or 2 * inside[n] > np.count_nonzero(label_map.voxels == n)
    ]


def _other_image(value: str) -> BadInput:
    return BadInput(
        value,
        "the occupancy grid is made from the same label map",
        "run build_occupancy_grid on this label map",
    )


def _clipped(cells: Float[np.ndarray, " n"], size: int) -> Int[np.ndarray, " n"]:
    """Return places in an axis that was padded by one; all beyond its ends fall on the padding."""
    return np.clip(np.rint(cells).astype(np.int64) + 1, 0, size - 1)


def _box_around(
    near: Bool[np.ndarray, "a b c"],
    cells: list[Int[np.ndarray, " _"]],
    reach_mm: float,
    spacing: Float[np.ndarray, "3"],
) -> tuple[slice, slice, slice]:
    """Return the box of voxels that holds all in these cells and within reach of it, and a voxel
    of what lies behind, so that air outside of the skin is seen."""
    sides = []
    for side, cell, step in zip(bounding_box(near), cells, spacing, strict=True):
        inside = np.flatnonzero((cell >= side.start) & (cell < side.stop))
        margin = int(np.ceil(reach_mm / step)) + 2
        sides.append(slice(max(int(inside[0]) - margin, 0), int(inside[-1]) + 1 + margin))
    return (sides[0], sides[1], sides[2])
