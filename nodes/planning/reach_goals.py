"""Proofs that a camera can see a goal from nowhere that its robot may be."""

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap, Volume, spacing_mm
from nodes.planning.artefacts import PlacedSetup
from nodes.planning.parameters import ClearanceParameters

Mask = Bool[np.ndarray, "i j k"]

ROUNDING_MM = 1e-3  # of distances that are kept as float32, and of places


def prove_unreachable(
    placed: PlacedSetup,
    camera_patient_mm: Float[np.ndarray, "3"],
    occupancy_grid: LabelMap,
    distance_field: Volume,
    cells: Int[np.ndarray, "cell 3"],
    clearances: ClearanceParameters,
) -> str:
    """Return why no motion can lead the camera to where it sees any of these cells, or "".

    Only what is certain counts. The camera stands in a free cell where the tool's round end has its
    radius and the margin as room, or in the sheath; no farther from the tool's entry point than the
    tool is long; and in cells that hang together, over faces, edges or corners, with that of the
    start. It sees a cell only at the end of a chain of free cells that never turns back along an
    axis, which every free ray is. Neither the tool's shape nor where the camera looks is regarded,
    so a goal that no one can see may have no proof.

    Parameters
    ----------
    placed : the set-up and its limits.
    camera_patient_mm : where the camera is at the start.
    occupancy_grid : with "free" cells.
    distance_field : of the same grid, to the walls.
    cells : indices of boundary cells, the goal.
    clearances : what the motion keeps to.
    """
    free = occupancy_grid.mask("free")
    sighting = _find_sighting(free, cells)
    if not sighting.any():
        return "no free cell from which a straight line could lead to it: it is behind others"
    needed = placed.setup.needles[0].radius_mm + clearances.margin_mm
    entry_mm = _distances_from(placed.setup.entry_points_patient_mm[0], occupancy_grid)
    slack = float(np.linalg.norm(spacing_mm(occupancy_grid.patient_from_index))) / 2 + ROUNDING_MM
    roomy = distance_field.voxels >= needed - slack
    roomy = free & (roomy | (entry_mm <= clearances.sheath_mm + slack))
    if not (sighting & roomy).any():
        return (
            "no place from which a straight line could lead to it has room for the tool, whose"
            f" radius and margin are {needed:.3g} mm"
        )
    longest = float(placed.longest_mm[0])
    least = float(entry_mm[sighting & roomy].min()) - slack
    if least > longest:
        return (
            "the nearest place from which a straight line could lead to it is"
            f" {least:.1f} mm from the tool's entry point, and the tool reaches {longest:g} mm"
        )
    cell = _cell_of(camera_patient_mm, occupancy_grid)
    reached = _hang_together(roomy & (entry_mm <= longest + slack), cell)
    if reached.any() and not (sighting & reached).any():
        return (
            "every place from which a straight line could lead to it is cut off from the start by"
            f" ways too narrow for the tool, whose radius and margin are {needed:.3g} mm, or by its"
            f" reach of {longest:g} mm"
        )
    return ""


def _find_sighting(free: Mask, cells: Int[np.ndarray, "cell 3"]) -> Mask:
    """Return the free cells from which a chain that never turns back leads to one of the cells."""
    from nodes.kernels.monotone_chains import mark_chains

    goals, found = np.zeros(free.shape, np.uint8), np.zeros(free.shape, np.uint8)
    goals[tuple(cells.T)] = 1
    mark_chains(free.view(np.uint8), goals, found)
    return found > 0


def _distances_from(point: Float[np.ndarray, "3"], grid: LabelMap) -> Float[np.ndarray, "i j k"]:
    """Return the distances of all cells' centres from a point, mm; the grid's axes are at right
    angles."""
    spacing = spacing_mm(grid.patient_from_index)
    index = transform_points(np.linalg.inv(grid.patient_from_index), point[None])[0]
    along = [
        (np.arange(count) - place) * step
        for count, place, step in zip(grid.voxels.shape, index, spacing, strict=True)
    ]
    squares = [a * a for a in along]
    return np.sqrt(squares[0][:, None, None] + squares[1][:, None] + squares[2])


def _cell_of(point: Float[np.ndarray, "3"], grid: LabelMap) -> tuple[int, ...]:
    index = transform_points(np.linalg.inv(grid.patient_from_index), point[None])[0]
    return tuple(int(c) for c in np.rint(index))


def _hang_together(roomy: Mask, cell: tuple[int, ...]) -> Mask:
    """Return the cells that hang together with one; none if it is not roomy itself."""
    from scipy import ndimage

    parts, _ = ndimage.label(roomy, np.ones((3, 3, 3), bool))
    inside = all(0 <= c < count for c, count in zip(cell, roomy.shape, strict=True))
    number = int(parts[cell]) if inside else 0
    return (parts == number) & (number > 0)
