"""The start of a tree of CRISP configurations: solved, stable and free."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.mechanics.crisp_edges import SOLVED, UNSTABLE, CrispEdges
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.parameters import FollowCrispEdgesParameters
from nodes.planning.artefacts import PlacedSetup
from nodes.planning.crisp_collisions import TOUCHES, check_steps
from nodes.planning.parameters import GrowCrispTreesParameters

if TYPE_CHECKING:
    from nodes.kernels.crisp_collision import Space

CURE = "start elsewhere, or let the set-up be searched"


def solve_start(
    placed: PlacedSetup, cavity: "Space", wall: "Space", parameters: GrowCrispTreesParameters
) -> tuple[Float[np.ndarray, "needle 6"], Float[np.ndarray, "4 4"]]:
    """Return wrenches at the entry points and patient_from_camera of a set-up's start.

    Raises
    ------
    BadInput : if the start bears loads, has no stable solution, or touches anything.
    """
    start = placed.start
    if start.loads:
        raise BadInput(
            f"{len(start.loads)} loads on the start of {placed.name}",
            "motions are planned for needles on which nothing pulls",
            "leave the loads out",
        )
    frames, lengths = start.patient_from_entry[None], start.lengths_mm[None]
    nothing = np.zeros((1, len(start.lengths_mm), 6))
    edge = CrispEdges(frames, frames, lengths, lengths, nothing, np.zeros(1, int))
    track = follow_crisp_edges(placed.setup, edge, follow_parameters(parameters))
    status, wrenches = track.status[0, 0], track.wrenches[:, 0]
    if status != SOLVED:
        what = "the robot would leave" if status == UNSTABLE else "cannot be solved"
        raise BadInput(
            f"the start of {placed.name} {what}", "a start is a stable equilibrium", CURE
        )
    touch = check_steps(placed.setup, frames, lengths, wrenches, parameters, cavity, wall)[0]
    if touch:
        raise BadInput(
            f"at the start of {placed.name} {TOUCHES[touch]}",
            f"a start keeps {parameters.margin_mm:g} mm from anatomy, and needles stay apart",
            CURE,
        )
    return wrenches[0], track.patient_from_camera[0, 0]


def follow_parameters(parameters: GrowCrispTreesParameters) -> FollowCrispEdgesParameters:
    """Return how edges are followed."""
    return FollowCrispEdgesParameters(
        tolerance_mm=parameters.tolerance_mm,
        integration_error_mm=parameters.integration_error_mm,
        largest_bend_rad=parameters.largest_bend_rad,
        iterations=parameters.iterations,
        steps_between_checks=parameters.steps_between_checks,
        refinements=parameters.refinements,
    )
