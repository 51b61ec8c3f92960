"""Whether robots can begin in configurations: solved from rest, stable, and touching nothing."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from nodes.mechanics.crisp_edges import (
    BRANCH_ENDS,
    NO_SOLUTION,
    NOT_CONVERGED,
    SOLVED,
    UNSTABLE,
    CrispEdges,
)
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.parameters import FollowCrispEdgesParameters
from nodes.mechanics.robots import CrispSetup
from nodes.planning.artefacts import PlacedSetup
from nodes.planning.crisp_collisions import TOUCHES, check_steps
from nodes.planning.parameters import ClearanceParameters

if TYPE_CHECKING:
    from nodes.kernels.crisp_collision import Space

Frames = Float[np.ndarray, "robot needle 3 3"]
Lengths = Float[np.ndarray, "robot needle"]

UNSOLVED = 100  # codes of touches are below it, those of no solution from it on
WHY = {
    NO_SOLUTION: "has no solution: a snare is too short to reach the tool",
    NOT_CONVERGED: "has no solution that was found",
    BRANCH_ENDS: "has no solution that was found",
    UNSTABLE: "is an equilibrium that the robot would leave",
}


class Scene(NamedTuple):
    """What starts are held against."""

    cavity: "Space"
    wall: "Space"
    clearances: ClearanceParameters
    solving: FollowCrispEdgesParameters


def judge_starts(setup: CrispSetup, frames: Frames, lengths_mm: Lengths, scene: Scene) -> Int[
    np.ndarray, "robot"
]:  # fmt: skip
    """Return 0 for each configuration that is solved from rest and touches nothing, else a code
    that `say_why` explains."""
    status, wrenches = solve_starts(setup, frames, lengths_mm, scene.solving)
    codes = np.where(status == SOLVED, 0, UNSOLVED + status)
    solved = np.flatnonzero(codes == 0)
    codes[solved] = check_steps(
        setup, frames[solved], lengths_mm[solved], wrenches[solved],
        scene.clearances, scene.cavity, scene.wall,
    )  # fmt: skip
    return codes


def solve_starts(
    setup: CrispSetup, frames: Frames, lengths_mm: Lengths, solving: FollowCrispEdgesParameters
) -> tuple[Int[np.ndarray, "robot"], Float[np.ndarray, "robot needle 6"]]:
    """Return status and wrenches of configurations, each solved from needles at rest."""
    nothing = np.zeros((*lengths_mm.shape, 6))
    still = np.zeros(len(lengths_mm), int)
    edges = CrispEdges(frames, frames, lengths_mm, lengths_mm, nothing, still)
    tracks = follow_crisp_edges(setup, edges, solving)
    return tracks.status[:, 0], tracks.wrenches[:, 0]


def say_why(code: int) -> str:
    """Return what a code of `judge_starts` means, as a sentence goes on after "the start"."""
    return f"touches: {TOUCHES[code]}" if code < UNSOLVED else WHY[code - UNSOLVED]


def find_tilts(placed: PlacedSetup, frames: Frames) -> Float[np.ndarray, "robot needle"]:
    """Return the angles between needles' tangents at their entries and their axes, rad."""
    tangents = frames[..., 2]
    across = np.linalg.norm(np.cross(tangents, placed.axes), axis=-1)
    return np.arctan2(across, np.einsum("rni,ni->rn", tangents, placed.axes))
