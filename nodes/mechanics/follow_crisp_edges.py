"""Solve straight, unloaded CRISP robots along edges of their configuration space, many at once."""

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.mechanics.crisp_edges import (
    BEYOND,
    NO_SOLUTION,
    NOT_CONVERGED,
    SOLVED,
    CrispEdges,
    CrispTracks,
)
from nodes.mechanics.crisp_lane_groups import Found, Motion, Problem, follow_lanes, pose_problem
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
    not bent yet and whose gaps are closed in steps. A step that finds no solution, or one far from
    where the branch leads, is cut into finer ones; where that fails too, the edge ends. An edge of
    no steps is one configuration to be solved.

    Raises
    ------
    BadInput : if a needle is curved when unloaded, which is for the general path; if joints pass
        one another on the tool, or leave it.
    """
    problem = pose_problem(setup, edges.start_lengths_mm)
    motion = _to_motion(problem, edges)
    is_short = _find_short(problem, motion)
    found = _follow_with_care(problem, motion, _count_true(~is_short) - 1, parameters)
    is_solved = found.totals * problem.unit_mm < parameters.tolerance_mm
    status = _tell(motion, np.logical_and.accumulate(is_solved & ~is_short, axis=1), is_short)
    return _to_tracks(problem, found, status)


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


def _count_true(flags: Bool[np.ndarray, "edge step"]) -> Int[np.ndarray, "edge"]:
    """Return how many flags are true before the first one that is not."""
    return np.where(flags.all(1), flags.shape[1], (~flags).argmax(1))


def _follow_with_care(
    problem: Problem,
    motion: Motion,
    last: Int[np.ndarray, "edge"],
    parameters: FollowCrispEdgesParameters,
) -> Found:
    """Follow all edges up to step `last`; where one stops, try its next step in finer ones."""
    tolerance = parameters.tolerance_mm / problem.unit_mm
    found = follow_lanes(problem, motion, parameters, is_exact=False)
    lost = np.flatnonzero(~(found.totals[:, 0] < tolerance) & (last >= 0))
    _begin_from_rest(problem, motion, found, lost, parameters)
    begun, level = _count_true(found.totals < tolerance) - 1, np.zeros(len(last), int)
    while True:
        stuck = (begun >= 0) & (begun < last) & (level <= parameters.refinements)
        if not stuck.any():
            return found
        for tried in np.unique(level[stuck]):
            chosen = np.flatnonzero(stuck & (level == tried))
            _go_on(problem, motion, found, chosen, begun[chosen], int(tried), parameters)
        reached = _count_true(found.totals < tolerance) - 1
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


def _begin_from_rest(
    problem: Problem,
    motion: Motion,
    found: Found,
    lost: Int[np.ndarray, "part"],
    parameters: FollowCrispEdgesParameters,
) -> None:
    """Solve lost starts from needles that are not bent: their gaps are closed in steps."""
    for level in range(1, parameters.refinements + 1 + MORE_FROM_REST):
        if not len(lost):
            break
        still = motion.hold(lost, FINER**level)
        closed = follow_lanes(problem, still, parameters, is_exact=True, from_rest=True)
        is_solved = closed.totals[:, -1] * problem.unit_mm < parameters.tolerance_mm
        for row in np.flatnonzero(is_solved):
            found.put(lost[row], -1, closed.take(row, FINER**level))
        lost = lost[~is_solved]


def _tell(
    motion: Motion,
    is_solved: Bool[np.ndarray, "edge step"],
    is_short: Bool[np.ndarray, "edge step"],
) -> Int[np.ndarray, "edge step"]:
    """Return the status of each step; after the first that is not solved nothing is known."""
    status = np.where(is_solved, SOLVED, BEYOND)
    ends = _count_true(is_solved)
    for edge in np.flatnonzero(ends <= motion.counts):
        status[edge, ends[edge]] = NO_SOLUTION if is_short[edge, ends[edge]] else NOT_CONVERGED
    return status


def _to_tracks(problem: Problem, found: Found, status: Int[np.ndarray, "edge step"]) -> CrispTracks:
    needles, snares = len(problem.setup.needles), problem.robot.snare
    wrenches = np.full((*status.shape, needles, 6), np.nan)
    wrenches[:, :, snares] = found.wrenches * problem.wrench_unit
    wrenches[:, :, 0] = _balance(problem, wrenches[:, :, 1:])
    poses, residual = problem.to_poses(found.tips), found.totals * problem.unit_mm
    for values in (wrenches, poses, residual):
        values[status != SOLVED] = np.nan
    return CrispTracks(status, wrenches, poses, residual)


def _balance(
    problem: Problem, wrenches: Float[np.ndarray, "edge step snare 6"]
) -> Float[np.ndarray, "edge step 6"]:
    """Return the tool's wrench, which balances those of all snares about its entry point."""
    entries = problem.setup.entry_points_patient_mm
    arms = np.cross((entries[1:] - entries[0])[:, None], np.eye(3)).reshape(-1, 3)
    moments, forces = wrenches[..., :3], wrenches[..., 3:]
    about = moments.sum(2) + forces.reshape(*forces.shape[:2], -1) @ arms
    return -np.concatenate([about, forces.sum(2)], axis=-1)
