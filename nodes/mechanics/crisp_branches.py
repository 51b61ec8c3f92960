"""What lanes cannot solve or follow, one at a time and with great care."""

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.mechanics.crisp_edges import BRANCH_ENDS, NOT_CONVERGED, SOLVED
from nodes.mechanics.crisp_lane_groups import Motion, Problem
from nodes.mechanics.crisp_reach import find_grasps
from nodes.mechanics.robots import CrispConfiguration
from nodes.mechanics.solve_crisp import to_crisp


def solve_starts(
    problem: Problem, motion: Motion, tolerance_mm: float
) -> Float[np.ndarray, "edge joint 6"]:
    """Return wrenches at the starts of edges, in the problem's units, found from needles at rest;
    nan where none are."""
    from nodes.kernels import crisp_general_cold, crisp_general_solve
    from nodes.kernels.crisp_general_problem import pack

    wrenches = np.full_like(motion.wrenches, np.nan)
    for edge, (frames, lengths) in enumerate(zip(motion.frames, motion.lengths, strict=True)):
        crisp = pack(to_crisp(problem.setup, CrispConfiguration(frames, lengths)))
        base, newton = np.zeros((len(lengths), 6)), crisp_general_solve.new_newton(crisp)
        status, *_ = crisp_general_cold.solve_from_rest(
            crisp, base, np.zeros((0, *base.shape)), tolerance_mm, newton
        )
        if status == crisp_general_solve.SOLVED:
            wrenches[edge] = base[problem.robot.snare] / problem.wrench_unit
    return wrenches


def find_unstable(
    problem: Problem,
    motion: Motion,
    wrenches: Float[np.ndarray, "edge joint 6"],
    wanted: Bool[np.ndarray, "edge"],
) -> Int[np.ndarray, "unstable"]:
    """Return which of the wanted edges start at an equilibrium that the robot would leave."""
    from nodes.kernels.crisp_general_batch import count_unstable
    from nodes.kernels.crisp_general_problem import pack

    edges = np.flatnonzero(wanted)
    if not len(edges):
        return edges
    frames, lengths = motion.frames[edges], motion.lengths[edges]
    crisp = pack(to_crisp(problem.setup, CrispConfiguration(frames[0], lengths[0])))
    arcs = find_grasps(problem.setup, lengths)
    found = np.zeros(len(edges), np.int64)
    count_unstable(crisp, frames, lengths, arcs, problem.to_wrenches(wrenches[edges]), found)
    return edges[found > 0]


def follow_branches(
    problem: Problem, motion: Motion
) -> tuple[Int[np.ndarray, "edge"], Float[np.ndarray, "edge joint 6"]]:
    """Return the status of the first step of each edge, and the wrenches at its end in the
    problem's units.

    Parameters
    ----------
    motion : its wrenches are equilibria at the edges' starts.
    """
    snares = problem.robot.snare
    status = np.full(len(motion.counts), NOT_CONVERGED)
    wrenches = np.full_like(motion.wrenches, np.nan)
    bases = problem.to_wrenches(motion.wrenches)
    for edge in range(len(status)):
        status[edge], base = _follow(problem, motion, edge, bases[edge])
        if status[edge] == SOLVED:
            wrenches[edge] = base[snares] / problem.wrench_unit
    return status, wrenches


def _follow(
    problem: Problem,
    motion: Motion,
    edge: int,
    wrenches: Float[np.ndarray, "needle 6"],
) -> tuple[int, Float[np.ndarray, "needle 6"]]:
    from nodes.kernels import crisp_branch, crisp_general_solve
    from nodes.kernels.crisp_general_problem import pack

    share, lengths = 1 / motion.counts[edge], motion.lengths[edge]
    crisp = to_crisp(problem.setup, CrispConfiguration(motion.frames[edge], lengths))
    growths = share * motion.growths[edge]
    near, far = find_grasps(problem.setup, np.stack([lengths, lengths + growths]))
    piece = crisp_branch.Piece(share * motion.turns[edge], growths, far - near)
    base = np.array(wrenches)
    status, _ = crisp_branch.follow_branch(pack(crisp), piece, base)
    if status == crisp_general_solve.SOLVED:
        return SOLVED, base
    return BRANCH_ENDS if status == crisp_general_solve.NO_SOLUTION else NOT_CONVERGED, base
