"""Which cells of the surface of a free space a camera sees."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from jaxtyping import Bool, Float, Int, Int8, Int32, UInt8

from nodes.errors import BadInput
from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.grids import LabelMap, spacing_mm
from nodes.geometry.surface_lists import list_blocks, list_faces

if TYPE_CHECKING:
    from nodes.kernels.cell_visibility import Surface

Reading = Literal["own ray", "first hit"]
"""How [Kuntz2017] Sec. IV-C is read: a cell is seen if the ray to itself is free, or if it is the
first obstacle cell on the ray to any cell within the field of view."""

FIRST_HIT = "first hit"
Vectors = Float[np.ndarray, "node 3"]
FirstNodes = Int[np.ndarray, "cell"]
View = tuple[Vectors, Vectors, float]  # cameras, views, squared cosine of half the field of view

PARTS = 2  # pieces of the surface that threads share; the result is the same for any number
FEW = 8  # cameras, for which lists are not worth their making
FACE_BLOCK, BLOCK = 16, 8  # cells along an axis whose surface is in one list; by trying


@dataclass(frozen=True)
class SurfaceCells:
    """The boundary cells of a free space, in the grid around them.

    Parameters
    ----------
    cells : (cell, 3) indices of the boundary cells, in the grid's order.
    numbers : (i, j, k) the place in `cells` of each of them, else -1.
    free : (i, j, k) 1 where the space is free.
    room : (i, j, k) of a free cell, how many cells away, along the axes, the next one is that is
        not free; of others, minus that of the next free one; at most 127.
    patient_from_index : (4, 4) of the grid.
    """

    cells: Int32[np.ndarray, "cell 3"]
    numbers: Int32[np.ndarray, "i j k"]
    free: UInt8[np.ndarray, "i j k"]
    room: Int8[np.ndarray, "i j k"]
    patient_from_index: Float[np.ndarray, "4 4"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


def find_surface(occupancy_grid: LabelMap) -> SurfaceCells:
    """Return the boundary cells of an occupancy grid, ready to be looked at.

    Raises
    ------
    BadInput where the grid's cells are no cubes, or the grid is too long for exact rays.
    """
    from nodes.kernels.cell_rays import MOST_CELLS

    _check_cubes(occupancy_grid.patient_from_index)
    longest = max(occupancy_grid.voxels.shape)
    if longest > MOST_CELLS:
        raise BadInput(
            f"a grid of {longest} cells along an axis",
            f"lines of sight are exact up to {MOST_CELLS} cells",
            "set a larger voxel_size_mm in build_occupancy_grid",
        )
    boundary = occupancy_grid.mask("boundary")
    cells = np.argwhere(boundary).astype(np.int32)
    numbers = np.full(boundary.shape, -1, np.int32)
    numbers[boundary] = np.arange(len(cells))
    free = occupancy_grid.mask("free")
    room = _cells_to_next(free) - _cells_to_next(~free)
    matrix = occupancy_grid.patient_from_index
    return SurfaceCells(cells, numbers, free.astype(np.uint8), room, matrix)


def _cells_to_next(mask: Bool[np.ndarray, "i j k"]) -> Int8[np.ndarray, "i j k"]:
    """Return how far each cell of a mask is from the next one outside, along the longest axis."""
    from scipy import ndimage

    far = np.iinfo(np.int8).max
    if mask.all():
        return np.full(mask.shape, far, np.int8)
    return np.minimum(ndimage.distance_transform_cdt(mask, "chessboard"), far).astype(np.int8)


def _check_cubes(patient_from_index: Float[np.ndarray, "4 4"]) -> None:
    axes = patient_from_index[:3, :3]
    side = spacing_mm(patient_from_index).max()
    if not np.allclose(axes.T @ axes, np.eye(3) * side**2, rtol=0, atol=1e-6 * side**2):
        raise BadInput(
            "an occupancy grid whose cells are no cubes",
            "a field of view is a cone in cells as it is in the patient",
            "make the grid with build_occupancy_grid",
        )


def half_view(field_of_view_deg: float) -> float:
    """Return the squared cosine of half a field of view, which is at most 180 degrees."""
    return float(1 + np.cos(np.deg2rad(field_of_view_deg))) / 2


def sees(
    surface: SurfaceCells,
    camera_patient_mm: Float[np.ndarray, "3"],
    view: Float[np.ndarray, "3"],
    field_of_view_deg: float,
    cell: Int[np.ndarray, "3"],
) -> bool:
    """Return whether a camera sees a cell: within its field of view, and nothing between.

    [Kuntz2017] Sec. IV-A: the angle between the view and the way to the cell's centre is at most
    half the field of view, and the ray between them crosses free cells only, but the cell itself.
    """
    from nodes.kernels.cell_rays import sees_cell

    i, j, k = cell.tolist()
    free, index_from_patient = surface.free, _index_from_patient(surface)
    half = half_view(field_of_view_deg)
    return bool(sees_cell(free, index_from_patient, camera_patient_mm, view, half, i, j, k))


def look(
    surface: SurfaceCells,
    cameras_patient_mm: Vectors,
    views: Vectors,
    field_of_view_deg: float,
    reading: Reading,
    first_nodes: FirstNodes,
    first: int = 0,
) -> int:
    """Mark in `first_nodes` which cells are seen; return how many cameras are not in free cells.

    Exact, and the same bit for bit as one ray to each cell from each camera, of which
    nodes.kernels.cell_rays tells. As a ray ends at its cell's centre, under "own ray" a flat wall
    along the grid's axes hides itself where it is met at less than 45 degrees.

    Parameters
    ----------
    cameras_patient_mm, views : (node, 3) places, mm, and directions of view in patient axes.
    reading : "own ray" marks a cell if it is seen itself ([Kuntz2017] Sec. IV-A), "first hit" the
        first obstacle cell on the ray to each boundary cell in the field of view (Sec. IV-C).
    first_nodes : (cell,) int64, changed in place: the least number of a node that sees each cell;
        -1 where none has yet.
    first : number of the first of these nodes.
    """
    cameras, views = np.ascontiguousarray(cameras_patient_mm), np.ascontiguousarray(views)
    view = cameras, views, half_view(field_of_view_deg)
    if len(cameras) < FEW:
        return look_plainly(surface, view, reading, first, first_nodes)
    parts = [first_nodes.copy() for _ in range(PARTS)]
    unseen = np.flatnonzero((first_nodes < 0) | (first_nodes > first))
    with ThreadPoolExecutor(PARTS) as pool:
        work = [
            pool.submit(_look_at_part, surface, view, reading, first, unseen, part, found)
            for part, found in enumerate(parts)
        ]
        blind = [done.result() for done in work]
    never = np.iinfo(np.int64).max
    found = np.min([np.where(part < 0, never, part) for part in parts], axis=0)
    first_nodes[:] = np.where(found == never, -1, found)
    return blind[0]


def look_anew(
    surface: SurfaceCells, cameras_patient_mm: Vectors, views: Vectors, field_of_view_deg: float
) -> Bool[np.ndarray, "node cell"]:
    """Return which cells each camera sees by itself, under "own ray"; as `look`, but for few cells
    and cameras of which all is wanted."""
    from nodes.kernels.cell_visibility import look_at_lists_anew

    cameras, views = np.ascontiguousarray(cameras_patient_mm), np.ascontiguousarray(views)
    seen = np.empty((len(cameras), len(surface.cells)), bool)
    every = np.arange(len(surface.cells))
    lists = list_faces(surface.cells, surface.free, every, FACE_BLOCK)
    view = cameras, views, half_view(field_of_view_deg)
    look_at_lists_anew(_to_kernel(surface), lists, *view, seen)
    return seen


def look_plainly(
    surface: SurfaceCells, view: View, reading: Reading, first: int, first_nodes: FirstNodes
) -> int:
    """Do what `look` does by one ray a cell and camera: slow, to compare with."""
    from nodes.kernels.cell_visibility import look_plainly as look_by_rays

    cameras, views, half = view
    view = np.ascontiguousarray(cameras), np.ascontiguousarray(views), half
    hits = reading == FIRST_HIT
    return int(look_by_rays(_to_kernel(surface), *view, hits, first, first_nodes))


def _look_at_part(
    surface: SurfaceCells,
    view: View,
    reading: Reading,
    first: int,
    unseen: Int[np.ndarray, " n"],
    part: int,
    first_nodes: FirstNodes,
) -> int:
    from nodes.kernels.cell_first_hits import look_for_first_hits
    from nodes.kernels.cell_visibility import look_at_lists

    kernel, is_hit = _to_kernel(surface), reading == FIRST_HIT
    size = BLOCK if is_hit else FACE_BLOCK
    lists = list_faces(surface.cells, surface.free, unseen, size, (part, PARTS))
    if is_hit:
        blocks = list_blocks(surface.cells, BLOCK)
        return int(look_for_first_hits(kernel, lists, blocks, *view, first, first_nodes))
    return int(look_at_lists(kernel, lists, *view, first, first_nodes))


def _to_kernel(surface: SurfaceCells) -> "Surface":
    from nodes.kernels.cell_visibility import Surface

    grids = surface.free, surface.room, _index_from_patient(surface)
    return Surface(surface.cells, surface.numbers, *grids)


def _index_from_patient(surface: SurfaceCells) -> Float[np.ndarray, "3 4"]:
    return np.ascontiguousarray(np.linalg.inv(surface.patient_from_index)[:3])
