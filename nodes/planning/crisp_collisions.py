"""Whether solved CRISP robots touch anything, many at once."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Int

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, spacing_mm
from nodes.mechanics.crisp_arrays import to_grasps
from nodes.mechanics.robots import CrispSetup
from nodes.mechanics.sample_crisp_needles import NeedlePoints, sample_crisp_needles
from nodes.planning.parameters import ClearanceParameters

if TYPE_CHECKING:
    from nodes.kernels.crisp_collision import Rules, Space

TOUCHES = ("", "a needle touches anatomy", "needles touch one another", "a sheath touches bone")
"""What the codes of check_steps mean."""


def check_steps(
    setup: CrispSetup,
    orientations: Float[np.ndarray, "robot needle 3 3"],
    lengths_mm: Float[np.ndarray, "robot needle"],
    wrenches: Float[np.ndarray, "robot needle 6"],
    clearances: ClearanceParameters,
    cavity: "Space",
    wall: "Space",
) -> Int[np.ndarray, "robot"]:
    """Return 0 for each robot that touches nothing, else a place in TOUCHES.

    Parameters
    ----------
    orientations : patient_from_entry of each needle.
    wrenches : of a solution: moment, N mm, and force, N, at the entry points, patient axes.
    cavity, wall : of make_cavity and make_wall.
    """
    if not len(lengths_mm):
        return np.zeros(0, int)
    pieces = count_pieces(lengths_mm, clearances.piece_mm)
    points = sample_crisp_needles(setup, orientations, lengths_mm, wrenches, pieces)
    order = needle_order(setup, lengths_mm)
    tangents = orientations[..., 2][:, order]
    return check_points(points, tangents, make_rules(setup, clearances, order), cavity, wall)


def check_points(
    points: NeedlePoints,
    tangents: Float[np.ndarray, "robot needle 3"],
    rules: "Rules",
    cavity: "Space",
    wall: "Space",
) -> Int[np.ndarray, "robot"]:
    """Return the same of points along needles and their tangents at the entry points, the needles
    in the kernel's order."""
    from nodes.kernels.crisp_collision import check_robots

    codes = np.empty(len(tangents), np.int64)
    tools, snares, ways = map(np.ascontiguousarray, (*points, tangents))
    check_robots(tools, snares, ways, rules, cavity, wall, codes)
    return codes


def make_rules(
    setup: CrispSetup, clearances: ClearanceParameters, order: Int[np.ndarray, "needle"]
) -> "Rules":
    """Return what counts as a touch as the kernel takes it, the needles in that order."""
    from nodes.kernels.crisp_collision import Rules

    radii = np.array([needle.radius_mm for needle in setup.needles])[order]
    return Rules(
        radii,
        clearances.margin_mm,
        clearances.sheath_mm,
        clearances.grasp_mm,
        clearances.outside_mm,
    )


def needle_order(
    setup: CrispSetup, lengths_mm: Float[np.ndarray, "robot needle"]
) -> Int[np.ndarray, "needle"]:
    """Return the needles in the kernel's order: tool, then snares as they grasp along the tool."""
    return np.concatenate([[0], to_grasps(setup, float(lengths_mm.flat[0])).snare])


def count_pieces(lengths_mm: Float[np.ndarray, "robot needle"], piece_mm: float) -> int:
    """Return into how many pieces needles are cut so that none is longer than `piece_mm`."""
    from nodes.kernels.crisp_collision import FEWEST_PIECES

    return max(FEWEST_PIECES, int(np.ceil(lengths_mm.max() / piece_mm)))


def refuse_coarse_cells(
    occupancy_grid: LabelMap, setup: CrispSetup, clearances: ClearanceParameters
) -> str:
    """Return what to say of cells that are coarse for the thinnest needle; "" if they are not.

    Raises
    ------
    BadInput : if they are coarser than allowed.
    """
    cell = float(spacing_mm(occupancy_grid.patient_from_index).max())
    radius = min(needle.radius_mm for needle in setup.needles)
    if cell > clearances.coarsest_cell * radius:
        raise BadInput(
            f"an occupancy grid with cells of {cell:g} mm for a needle of {2 * radius:g} mm",
            f"cells are at most {clearances.coarsest_cell:g} of the thinnest needle's radii",
            f"set voxel_size_mm to {clearances.coarsest_cell * radius:.2g} or less",
        )
    if cell > radius:
        return (
            f"cells of {cell:g} mm are larger than the radius of the thinnest needle,"
            f" {radius:g} mm: gaps as narrow as the needle are not shown"
        )
    return ""
