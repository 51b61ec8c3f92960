"""What the robot does along a motion: each configuration solved from the one before it.

By the general solver of mechanics, which knows nothing of how planners follow edges.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.mechanics.crisp_solution import CrispSolution
from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Needle
from nodes.mechanics.solve_crisp import solve_crisp
from nodes.mechanics.solve_crisp_batch import (
    CrispChain,
    sample_crisp_batch,
    solve_crisp_batch,
)
from nodes.planning.checking_steps import FineMotion, say_where
from nodes.planning.parameters import CheckCrispPlansParameters

_NO_POSES = np.empty((0, 4, 4))


class Course(NamedTuple):
    """One needle along a motion, at the same shares of its length in each configuration.

    Parameters
    ----------
    arcs_mm : (c, q) from the entry point.
    points, tangents : (c, q, 3) patient mm, and unit vectors.
    """

    arcs_mm: np.ndarray
    points: np.ndarray
    tangents: np.ndarray


class Followed(NamedTuple):
    """The solved configurations from the start on.

    Parameters
    ----------
    courses : the tool's first.
    wrenches : (c, needle, 6).
    margins : (c,) at least the stability margins.
    strains : (c, needle).
    cameras : (c, 4, 4).
    lost : why the next configuration has no solution; empty if all are solved.
    """

    courses: tuple[Course, ...]
    wrenches: np.ndarray
    margins: np.ndarray
    strains: np.ndarray
    cameras: np.ndarray
    lost: str


def follow_motion(
    setup: CrispSetup,
    fine: FineMotion,
    seed: Float[np.ndarray, "needle 6"],
    parameters: CheckCrispPlansParameters,
) -> Followed:
    """Solve all configurations of a motion up to the first that has no stable solution."""
    try:
        chain = solve_crisp_batch(setup, fine.orientations, fine.lengths_mm, seed, parameters)
    except BadInput as error:  # no fault of who asks for the check: the motion is refused
        chain = CrispChain(np.empty((0, len(seed), 6)), np.empty(0), str(error.value))
    count = len(chain.margins)
    lost = ""
    if chain.lost:
        lost = f"{say_where(fine.at[count])} the robot finds no stable shape: {chain.lost}"
    if not count:
        return Followed((), chain.wrenches, chain.margins, np.empty((0, 0)), _NO_POSES, lost)
    turns, lengths = fine.orientations[:count], fine.lengths_mm[:count]
    places = tuple(place_samples(own, parameters) for own in lengths.T)
    states = sample_crisp_batch(
        setup, turns, lengths, chain.wrenches, places, parameters.tolerance_mm
    )
    return Followed(
        tuple(
            Course(arcs, state[:, :, :3], state[:, :, 9:12])
            for arcs, state in zip(places, states, strict=True)
        ),
        chain.wrenches,
        chain.margins - parameters.margin_accuracy,
        np.stack([_strain(*each) for each in zip(setup.needles, states, strict=True)], axis=1),
        _camera(states[0]),
        lost,
    )


def _strain(needle: Needle, states: Float[np.ndarray, "c q 18"]) -> Float[np.ndarray, "c"]:
    """Return the largest strain of bending at a straight needle's surface."""
    moments = np.einsum("cqai,cqi->cqa", states[:, :, 3:9].reshape(*states.shape[:2], 2, 3),
                        states[:, :, 12:15])  # fmt: skip
    largest = np.linalg.norm(moments, axis=2).max(axis=1)
    return largest / needle.bending_stiffness * needle.radius_mm


def _camera(tool: Float[np.ndarray, "c q 18"]) -> Float[np.ndarray, "c 4 4"]:
    """Return the poses of the tool's tip."""
    poses = np.tile(np.eye(4), (len(tool), 1, 1))
    poses[:, :3, 3] = tool[:, -1, :3]
    poses[:, :3, :3] = np.swapaxes(tool[:, -1, 3:12].reshape(-1, 3, 3), 1, 2)
    return poses


def rest_at_start(
    setup: CrispSetup, fine: FineMotion, parameters: CheckCrispPlansParameters
) -> CrispSolution:
    """Return the shape in which the robot rests in the first configuration, whatever is claimed."""
    return solve_crisp(
        setup, CrispConfiguration(fine.orientations[0], fine.lengths_mm[0]), parameters
    )


def place_samples(
    lengths_mm: Float[np.ndarray, "c"], parameters: CheckCrispPlansParameters
) -> Float[np.ndarray, "c q"]:
    """Return where a needle is looked at, mm from its entry point: as many places in all
    configurations, one of them where the longest sheath ends."""
    sheath, spacing = parameters.sheath_mm, parameters.sample_spacing_mm
    held = np.minimum(sheath, lengths_mm)[:, None]
    rest = lengths_mm[:, None] - held
    first = np.linspace(0.0, 1.0, int(np.ceil(held.max() / spacing)) + 1)
    then = np.linspace(0.0, 1.0, int(np.ceil(rest.max() / spacing)) + 1)
    return np.concatenate([first[:-1] * held, held + then * rest], axis=1)
