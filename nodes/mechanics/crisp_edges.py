"""Motions of a CRISP robot between configurations, many at once, and what is found on them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.geometry.arrays import freeze_arrays


@dataclass(frozen=True)
class CrispEdges:
    """Edges of the configuration space: orientations turn at constant speed, lengths grow evenly.

    Parameters
    ----------
    starts, ends : (edge, needle, 3, 3) rotations of the needles where they enter, the tool first.
    start_lengths_mm, end_lengths_mm : (edge, needle) beyond the entry points, mm.
    start_wrenches : (edge, needle, 6) moment, N mm, and force, N, inside the needles at their entry
        points, patient axes: the solution at the start, or a guess of it; the tool's are not read.
    steps : (edge,) into how many steps each is cut.
    """

    starts: Float[np.ndarray, "edge needle 3 3"]
    ends: Float[np.ndarray, "edge needle 3 3"]
    start_lengths_mm: Float[np.ndarray, "edge needle"]
    end_lengths_mm: Float[np.ndarray, "edge needle"]
    start_wrenches: Float[np.ndarray, "edge needle 6"]
    steps: Int[np.ndarray, "edge"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


SOLVED, NO_SOLUTION, NOT_CONVERGED, BEYOND, BRANCH_ENDS, UNSTABLE = 0, 1, 2, 3, 4, 5


@dataclass(frozen=True)
class CrispTracks:
    """What was found at each step of edges, the start first; nan where nothing was found.

    Parameters
    ----------
    status : (edge, step) SOLVED; NO_SOLUTION where a snare is too short; BRANCH_ENDS where the
        equilibrium that is followed ceases to be one before this step: its stability margin falls
        to 0, and the robot snaps to another; UNSTABLE where a start that was found without wrenches
        is an equilibrium that the robot would leave; NOT_CONVERGED; BEYOND the end of the edge, or
        after a step that is not solved.
    from_rest : (edge,) whether the start was found from needles that are not bent, since the
        wrenches that were handed in led to no solution.
    wrenches : (edge, step, needle, 6) moment, N mm, and force, N, at the entry points.
    patient_from_camera : (edge, step, 4, 4) rigid, mm.
    residual_mm : (edge, step) sum of what is left of the joints' conditions, and a tenth of how far
        the wrenches are off; angles and moments as the gap that they make over the needles' mean
        length.
    """

    status: Int[np.ndarray, "edge step"]
    from_rest: Bool[np.ndarray, "edge"]
    wrenches: Float[np.ndarray, "edge step needle 6"]
    patient_from_camera: Float[np.ndarray, "edge step 4 4"]
    residual_mm: Float[np.ndarray, "edge step"]

    def __post_init__(self) -> None:
        freeze_arrays(self)
