"""Solve straight, unloaded CRISP robots along edges of their configuration space, many at once."""

from dataclasses import fields
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Int

from nodes.errors import BadInput
from nodes.mechanics.crisp_branches import find_unstable, follow_branches, solve_starts
from nodes.mechanics.crisp_edges import (
    BEYOND,
    NO_SOLUTION,
    NOT_CONVERGED,
    SOLVED,
    UNSTABLE,
    CrispEdges,
    CrispTracks,
)
from nodes.mechanics.crisp_lane_groups import (
    Found,
    Motion,
    Problem,
    count_true,
    follow_lanes,
    pose_problem,
)
from nodes.mechanics.crisp_reach import find_grasps, is_too_short
from nodes.mechanics.parameters import FollowCrispEdgesParameters
from nodes.mechanics.robots import CrispSetup

FINER = 4  # a step that finds no solution is cut into so many, and each of those again
MORE_FROM_REST = 2  # more such cuts of the way from needles that are not bent, which is long


def follow_crisp_edges(
    setup: CrispSetup, edges: CrispEdges, parameters: FollowCrispEdgesParameters
) -> CrispTracks:
    """Return what a robot does along edges, each followed from its start as one branch.

    The start is solved from the wrenches handed in, or, where that fails, from needles that are
    not bent yet and whose gaps are closed in steps, which the track tells. A step that finds no
    solution, or one far from where the branch leads, is cut into finer ones, and at last the curve
    of equilibria is followed by its length, which shows where the branch ends. An edge of no steps
    is one configuration to be solved. A start that is found without wrenches must be stable; one
    that is found from those handed in is on the caller's branch, and is not asked. Along a track an
    equilibrium stays stable, or stays unstable.

    Raises
    ------
    BadInput : if a number is not finite; if a needle is curved when unloaded, which is for the
        general path; if joints pass one another on the tool, or leave it.
    """
    _check_finite(edges)
    problem = pose_problem(setup, edges.start_lengths_mm)
    motion = _to_motion(problem, edges)
    is_short = _find_short(problem, motion)
    found, outcome = _follow_with_care(problem, motion, count_true(~is_short) - 1, parameters)
    is_solved = found.totals * problem.unit_mm < parameters.tolerance_mm
    is_solved = np.logical_and.accumulate(is_solved & ~is_short, axis=1)
    is_guessed = outcome.from_rest | ~edges.start_wrenches.any(axis=(1, 2))
    leaves = find_unstable(problem, motion, found.wrenches[:, 0], is_guessed & is_solved[:, 0])
    is_solved[leaves], outcome.why[leaves] = False, UNSTABLE
    return _to_tracks(problem, found, _tell(motion, is_solved, is_short, outcome.why), outcome)


def _check_finite(edges: CrispEdges) -> None:
    for field in fields(edges):
        wrong = ~np.isfinite(getattr(edges, field.name)).reshape(len(edges.steps), -1).all(axis=1)
        for edge in np.flatnonzero(wrong)[:1]:
            raise BadInput(
                f"{field.name} of edge {edge} holds nan or infinity",
                "all numbers of an edge are finite; wrenches that are not known are zeros",
                "leave such edges out",
            )


def _to_motion(problem: Problem, edges: CrispEdges) -> Motion:
    from scipy.spatial.transform import Rotation

    apart = edges.ends @ edges.starts.swapaxes(-1, -2)
    turns = Rotation.from_matrix(apart.reshape(-1, 3, 3)).as_rotvec().reshape(apart.shape[:3])
    return Motion(
        edges.starts,
        turns,
        edges.start_lengths_mm,
        edges.end_lengths_mm - edges.start_lengths_mm,
        edges.start_wrenches[:, problem.robot.snare] / problem.wrench_unit,
        edges.steps,
    )


def _find_short(problem: Problem, motion: Motion) -> Bool[np.ndarray, "edge step"]:
    """Return the steps of edges, and all beyond their ends, at which needles cannot meet."""
    steps = np.arange(motion.counts.max() + 1)
    share = steps / np.maximum(motion.counts, 1)[:, None]
    lengths = motion.lengths[:, None] + np.minimum(share, 1)[..., None] * motion.growths[:, None]
    is_short = is_too_short(problem.setup, lengths, find_grasps(problem.setup, lengths))
    return is_short | (steps > motion.counts[:, None])


class Outcome(NamedTuple):
    """Why each edge ended, unless it was solved or too short, and whether it began from rest."""

    why: np.ndarray
    from_rest: np.ndarray


def _follow_with_care(
    problem: Problem,
    motion: Motion,
    last: Int[np.ndarray, "edge"],
    parameters: FollowCrispEdgesParameters,
) -> tuple[Found, Outcome]:
    """Follow all edges up to step `last`; where one stops, try its next step in finer ones, and at
    last along the curve of equilibria."""
    tolerance = parameters.tolerance_mm / problem.unit_mm
    found = follow_lanes(problem, motion, parameters, is_exact=False)
    is_lost = ~(found.totals[:, 0] < tolerance) & (last >= 0)
    _begin_from_rest(problem, motion, found, np.flatnonzero(is_lost), parameters)
    begun, level = count_true(found.totals < tolerance) - 1, np.zeros(len(last), int)
    why, has_ended = np.full(len(last), NOT_CONVERGED), begun < 0
    while True:
        stuck = (begun < last) & ~has_ended
        if not stuck.any():
            return found, Outcome(why, is_lost & (begun >= 0))
        for tried in np.unique(level[stuck]):
            chosen = np.flatnonzero(stuck & (level == tried))
            if tried <= parameters.refinements:
                _go_on(problem, motion, found, chosen, begun[chosen], int(tried), parameters)
            else:
                why[chosen] = _go_round(problem, motion, found, chosen, begun[chosen], parameters)
                has_ended[chosen] = why[chosen] != SOLVED
        reached = count_true(found.totals < tolerance) - 1
        level = np.where(reached > begun, 0, level + 1)
        begun = reached


def _go_on(
    problem: Problem,
    motion: Motion,
    found: Found,
    chosen: Int[np.ndarray, "part"],
    first: Int[np.ndarray, "part"],
    level: int,
    parameters: FollowCrispEdgesParameters,
) -> None:
    """Follow the rest of chosen edges at level 0, else one step of them cut into finer ones."""
    finer = FINER**level
    rest = motion.cut(chosen, first, found.wrenches[chosen, first])
    if level > 0:
        rest = rest.first_step(finer)
    more = follow_lanes(problem, rest, parameters, is_exact=False)
    for row, edge in enumerate(chosen):
        found.put(edge, first[row], more.take(row, finer))


def _go_round(
    problem: Problem,
    motion: Motion,
    found: Found,
    chosen: Int[np.ndarray, "part"],
    first: Int[np.ndarray, "part"],
    parameters: FollowCrispEdgesParameters,
) -> Int[np.ndarray, "part"]:
    """Follow one step of chosen edges along the curve of equilibria; return what came of it."""
    rest = motion.cut(chosen, first, found.wrenches[chosen, first])
    status, wrenches = follow_branches(problem, rest)
    solved = np.flatnonzero(status == SOLVED)
    if len(solved):
        there = motion.cut(chosen[solved], first[solved] + 1, wrenches[solved]).hold()
        more = follow_lanes(problem, there, parameters, is_exact=True)
        for row, place in enumerate(solved):
            found.put(chosen[place], first[place], more.take(row, 0))
        is_lost = ~(more.totals[:, 0] * problem.unit_mm < parameters.tolerance_mm)
        status[solved[is_lost]] = NOT_CONVERGED
    return status


def _begin_from_rest(
    problem: Problem,
    motion: Motion,
    found: Found,
    lost: Int[np.ndarray, "part"],
    parameters: FollowCrispEdgesParameters,
) -> None:
    """Solve lost starts from needles that are not bent: their gaps are closed in steps, in lanes
    and at last one by one."""
    for level in range(1, parameters.refinements + 1 + MORE_FROM_REST):
        if not len(lost):
            break
        start = motion.cut(lost, 0 * lost, np.zeros_like(motion.wrenches[lost]))
        still = start.hold(FINER**level)
        closed = follow_lanes(problem, still, parameters, is_exact=True, from_rest=True)
        is_solved = closed.totals[:, -1] * problem.unit_mm < parameters.tolerance_mm
        for row in np.flatnonzero(is_solved):
            found.put(lost[row], -1, closed.take(row, FINER**level))
        lost = lost[~is_solved]
    if len(lost):
        start = motion.cut(lost, 0 * lost, motion.wrenches[lost])
        start = start._replace(wrenches=solve_starts(problem, start, parameters.tolerance_mm))
        solved = follow_lanes(problem, start.hold(), parameters, is_exact=True)
        for row, edge in enumerate(lost):
            found.put(edge, -1, solved.take(row, 0))


def _tell(
    motion: Motion,
    is_solved: Bool[np.ndarray, "edge step"],
    is_short: Bool[np.ndarray, "edge step"],
    why: Int[np.ndarray, "edge"],
) -> Int[np.ndarray, "edge step"]:
    """Return the status of each step; after the first that is not solved nothing is known."""
    status = np.where(is_solved, SOLVED, BEYOND)
    ends = count_true(is_solved)
    for edge in np.flatnonzero(ends <= motion.counts):
        status[edge, ends[edge]] = NO_SOLUTION if is_short[edge, ends[edge]] else why[edge]
    return status


def _to_tracks(
    problem: Problem, found: Found, status: Int[np.ndarray, "edge step"], outcome: Outcome
) -> CrispTracks:
    """Return the tracks; where a step is not solved, nothing."""
    residual = found.totals * problem.unit_mm
    wrenches, poses = problem.to_wrenches(found.wrenches), problem.to_poses(found.tips)
    for values in (wrenches, poses, residual):
        values[status != SOLVED] = np.nan
    return CrispTracks(status, outcome.from_rest, wrenches, poses, residual)
