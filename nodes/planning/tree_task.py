"""What the kernel that grows a tree of CRISP configurations has to know of a set-up."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from nodes.mechanics.crisp_arrays import to_grasps
from nodes.mechanics.crisp_lane_groups import Problem
from nodes.mechanics.crisp_reach import find_grasps
from nodes.planning.artefacts import PlacedSetup
from nodes.planning.crisp_collisions import count_pieces, make_rules, needle_order
from nodes.planning.parameters import GrowCrispTreesParameters
from nodes.planning.tree_memory import Sizes

if TYPE_CHECKING:
    from nodes.kernels.crisp_collision import Space
    from nodes.kernels.crisp_straight_edges import Rules
    from nodes.kernels.crisp_tree import Task
    from nodes.kernels.crisp_tree_chance import Region
    from nodes.kernels.crisp_tree_front import Scale


def make_sizes(placed: PlacedSetup, parameters: GrowCrispTreesParameters) -> Sizes:
    """Return how large the kernel's arrays are."""
    pieces = count_pieces(placed.longest_mm[None], parameters.piece_mm)
    setup = placed.setup
    return Sizes(len(setup.needles), len(setup.snares), pieces, parameters.chunk_steps)


def make_task(
    placed: PlacedSetup,
    problem: Problem,
    wrenches: Float[np.ndarray, "joint 6"],
    spaces: tuple["Space", "Space"],
    parameters: GrowCrispTreesParameters,
    most: int,
) -> "Task":
    """Return all that does not change while a tree grows.

    Parameters
    ----------
    wrenches : of the start, in the problem's unit.
    spaces : cavity and wall.
    most : nodes of the tree.
    """
    from nodes.kernels.crisp_lanes import LANES, make_lanes
    from nodes.kernels.crisp_tree import Task

    setup, start = placed.setup, placed.start
    seed = make_lanes(6 * len(setup.snares))
    if parameters.seed_from == "start":
        seed[:] = np.repeat(wrenches.reshape(-1, 1), LANES, 1)
    return Task(
        problem.robot,
        make_follow_rules(parameters, problem.unit_mm),
        make_rules(setup, parameters, needle_order(setup, start.lengths_mm[None])),
        *spaces,
        _make_region(placed),
        _make_scale(placed, problem, parameters),
        np.array(setup.entry_points_patient_mm[0]),
        _limit_curvatures(placed, problem, parameters),
        parameters.piece_mm,
        np.full(len(setup.needles), 2 * parameters.lever_mm),
        seed,
        parameters.seed_from == "parent",
        parameters.chunk_steps,
        most,
        parameters.joints_at_walls == "some",
    )


def make_follow_rules(parameters: GrowCrispTreesParameters, unit_mm: float) -> "Rules":
    """Return how the kernel follows edges."""
    from nodes.kernels.crisp_straight_edges import Rules

    return Rules(
        parameters.tolerance_mm / unit_mm,
        parameters.integration_error_mm / unit_mm,
        parameters.largest_bend_rad,
        parameters.iterations,
        parameters.steps_between_checks,
        False,
        False,
    )


def _limit_curvatures(
    placed: PlacedSetup, problem: Problem, parameters: GrowCrispTreesParameters
) -> Float[np.ndarray, "needle"]:
    """Return the largest squared curvatures: strain at a needle's surface is radius over bend."""
    strains = np.array([one.material.recoverable_strain for one in placed.setup.needles])
    radii = np.array([one.radius_mm for one in placed.setup.needles])
    return np.square(parameters.largest_strain * strains / radii * problem.unit_mm)


def _make_region(placed: PlacedSetup) -> "Region":
    from nodes.kernels.crisp_tree_chance import Region

    quaternions = np.array([_turn_from_z(axis) for axis in placed.axes])
    limits = placed.shortest_mm, placed.longest_mm
    heights = np.cos(placed.largest_tilts_rad)
    return Region(quaternions, np.array(placed.axes), heights, *map(np.array, limits))


def _turn_from_z(axis: Float[np.ndarray, "3"]) -> Float[np.ndarray, "4"]:
    """Return the quaternion of the shortest turn from e_z to a unit vector."""
    if axis[2] < 0:  # half a turn about x first, so that nothing is divided by almost 0
        w, x, y, z = _turn_from_z(axis * [1, -1, -1])
        return np.array([-x, w, -z, y])
    q = np.array([1 + axis[2], -axis[1], axis[0], 0.0])
    return q / np.linalg.norm(q)


def _make_scale(
    placed: PlacedSetup, problem: Problem, parameters: GrowCrispTreesParameters
) -> "Scale":
    """Return how configurations become poses; refuses joints that pass one another on the tool."""
    from nodes.kernels.crisp_tree_front import Scale

    setup = placed.setup
    find_grasps(setup, np.stack([placed.shortest_mm, placed.longest_mm, placed.start.lengths_mm]))
    tool = float(placed.start.lengths_mm[0])
    order = to_grasps(setup, tool).snare
    snares = {snare.needle: snare for snare in setup.snares}
    slides = np.array([float(snares[needle].measured_from == "tip") for needle in order])
    places = to_grasps(setup, tool).arc
    return Scale(
        problem.unit_mm,
        slides,
        places - slides * tool,
        float(np.radians(parameters.step_deg)),
        parameters.step_mm,
    )
