"""Geodesics of the configuration space: cut into steps, solved, and tested."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.mechanics.crisp_edges import SOLVED, CrispEdges
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.sample_crisp_needles import sample_crisp_needles
from nodes.planning.artefacts import PlacedSetup
from nodes.planning.crisp_collisions import (
    check_points,
    count_pieces,
    make_rules,
    needle_order,
)
from nodes.planning.parameters import PlanCrispMotionsParameters
from nodes.planning.plan_paths import Lengths, Orientations, Path, turns_between
from nodes.planning.plan_strains import find_strains

if TYPE_CHECKING:
    from nodes.kernels.crisp_collision import Rules, Space

ROUNDING = 1e-9  # of angles and lengths at their limits, rad and mm


class Ground(NamedTuple):
    """Where a robot moves, and what its motions keep to."""

    placed: PlacedSetup
    cavity: "Space"
    wall: "Space"
    parameters: PlanCrispMotionsParameters


class Ends(NamedTuple):
    """Both ends of geodesics, and the wrenches that are known there; the edge first."""

    starts: Orientations
    ends: Orientations
    start_lengths_mm: Lengths
    end_lengths_mm: Lengths
    start_wrenches: np.ndarray
    end_wrenches: np.ndarray


class Walked(NamedTuple):
    """What is at the steps of geodesics, the edge and then the step first, up to the longest's.

    counts : (edge,) steps of each; its configurations are one more.
    is_solved : (edge, step) all up to this step are found.
    """

    counts: np.ndarray
    orientations: np.ndarray
    lengths_mm: np.ndarray
    wrenches: np.ndarray
    patient_from_camera: np.ndarray
    is_solved: np.ndarray

    def cut(self, edge: int) -> Path:
        """Return one edge as a way."""
        rows = edge, slice(self.counts[edge] + 1)
        corners = np.array([0, self.counts[edge]])
        return Path(self.orientations[rows], self.lengths_mm[rows], self.wrenches[rows], corners)


def pick_ends(path: Path, firsts: Int[np.ndarray, "edge"], lasts: Int[np.ndarray, "edge"]) -> Ends:
    """Return geodesics between places of a way."""
    return Ends(
        path.orientations[firsts], path.orientations[lasts],
        path.lengths_mm[firsts], path.lengths_mm[lasts],
        path.wrenches[firsts], path.wrenches[lasts],
    )  # fmt: skip


def walk_edges(ground: Ground, ends: Ends, finer: int = 1) -> Walked:
    """Return geodesics cut into steps no longer than the parameters allow, each cut finer, solved.

    Parameters
    ----------
    finer : into how many parts each step is cut.
    """
    counts = finer * _count_steps(ends, ground.parameters)
    edges = CrispEdges(
        ends.starts, ends.ends, ends.start_lengths_mm, ends.end_lengths_mm,
        ends.start_wrenches, counts,
    )  # fmt: skip
    tracks = follow_crisp_edges(ground.placed.setup, edges, ground.parameters)
    orientations, lengths = _interpolate(ends, counts)
    return Walked(
        counts,
        orientations,
        lengths,
        tracks.wrenches,
        tracks.patient_from_camera,
        tracks.status == SOLVED,
    )


def _count_steps(ends: Ends, parameters: PlanCrispMotionsParameters) -> Int[np.ndarray, "edge"]:
    turns = np.linalg.norm(turns_between(ends.starts, ends.ends), axis=-1)
    growths = np.abs(ends.end_lengths_mm - ends.start_lengths_mm)
    parts = np.maximum(turns / np.radians(parameters.step_deg), growths / parameters.step_mm)
    return np.maximum(1, np.ceil(parts.max(axis=1) - ROUNDING)).astype(int)


def _interpolate(
    ends: Ends, counts: Int[np.ndarray, "edge"]
) -> tuple[Float[np.ndarray, "edge step needle 3 3"], Float[np.ndarray, "edge step needle"]]:
    """Return orientations and lengths at all steps; beyond an edge's last, those of its end."""
    from scipy.spatial.transform import Rotation

    share = np.minimum(np.arange(counts.max() + 1) / counts[:, None], 1.0)[:, :, None]
    turns = share[..., None] * turns_between(ends.starts, ends.ends)[:, None]
    turned = Rotation.from_rotvec(turns.reshape(-1, 3)).as_matrix()
    orientations = turned.reshape(*turns.shape[:3], 3, 3) @ ends.starts[:, None]
    lengths = (1 - share) * ends.start_lengths_mm[:, None] + share * ends.end_lengths_mm[:, None]
    return orientations, lengths


def find_valid(ground: Ground, walked: Walked) -> Bool[np.ndarray, "edge step"]:
    """Return which steps are solved, within the set-up's limits, and touch nothing; those beyond an
    edge's last one count as valid."""
    return _find_good(ground, walked, 0.0, np.inf)


def find_good(ground: Ground, walked: Walked) -> Bool[np.ndarray, "edge step"]:
    """Return which of them keep, on top, the reserve of distance and strain that short cuts keep,
    so that what lies between steps is valid, too."""
    parameters = ground.parameters
    return _find_good(ground, walked, parameters.reserve_mm, parameters.largest_strain)


def _find_good(
    ground: Ground, walked: Walked, reserve_mm: float, largest_strain: float
) -> Bool[np.ndarray, "edge step"]:
    setup = ground.placed.setup
    is_beyond = np.arange(walked.is_solved.shape[1]) > walked.counts[:, None]
    is_good = walked.is_solved & _keep_limits(ground.placed, walked)
    asked = is_good & ~is_beyond
    if asked.any():
        orientations, lengths = walked.orientations[asked], walked.lengths_mm[asked]
        wrenches = walked.wrenches[asked]
        pieces = count_pieces(ground.placed.longest_mm[None], ground.parameters.piece_mm)
        points = sample_crisp_needles(setup, orientations, lengths, wrenches, pieces)
        order = needle_order(setup, lengths)
        rules, tangents = _make_rules(ground, order, reserve_mm), orientations[..., 2][:, order]
        codes = check_points(points, tangents, rules, ground.cavity, ground.wall)
        strains = find_strains(setup, points, wrenches, order)
        is_good[asked] = (codes == 0) & (strains <= largest_strain)
    return is_good | is_beyond


def _make_rules(ground: Ground, order: Int[np.ndarray, "needle"], reserve_mm: float) -> "Rules":
    """Return what counts as a touch; sheaths end where there is the margin and all of the reserve,
    whatever of it is kept after that."""
    rules = make_rules(ground.placed.setup, ground.parameters, order)
    full = rules.margin + ground.parameters.reserve_mm
    return rules._replace(margin=rules.margin + reserve_mm, clear=full)


def _keep_limits(placed: PlacedSetup, walked: Walked) -> Bool[np.ndarray, "edge step"]:
    cosines = np.einsum("esnk,nk->esn", walked.orientations[..., 2], placed.axes)
    is_upright = cosines >= np.cos(placed.largest_tilts_rad + ROUNDING)
    is_long = walked.lengths_mm >= placed.shortest_mm - ROUNDING
    is_short = walked.lengths_mm <= placed.longest_mm + ROUNDING
    return np.all(is_upright & is_long & is_short, axis=-1)


def end_alike(ground: Ground, ends: Ends, walked: Walked) -> Bool[np.ndarray, "edge"]:
    """Return which geodesics arrive at the equilibrium that is known at their ends; of two needles
    in one pose, other wrenches are another shape."""
    setup = ground.placed.setup
    last = np.arange(len(walked.counts)), walked.counts
    apart = np.abs(walked.wrenches[last] - ends.end_wrenches)
    length = walked.lengths_mm[last].mean(axis=1)[:, None]
    moment = setup.needles[0].bending_stiffness / length
    scale = np.concatenate([np.repeat(moment, 3, 1), np.repeat(moment / length, 3, 1)], axis=1)
    return np.all(apart < ground.parameters.same_branch * scale[:, None], axis=(1, 2))
