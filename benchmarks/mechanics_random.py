"""Random CRISP robots along random edges: how often is no solution found?"""

from typing import Any

import numpy as np

from benchmarks.mechanics_cases import random_crisp
from benchmarks.mechanics_edges import (
    FOLLOW,
    SHAPE,
    edge_error,
    edges_between,
    near_by,
    random_targets,
    solve_near,
)
from nodes.mechanics.crisp_edges import BEYOND, BRANCH_ENDS, NO_SOLUTION, SOLVED
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.solve_crisp import solve_crisp


def run_random_crisp(count: int) -> dict[str, Any]:
    """Follow random edges of random robots; return how many solves fail, for 2, 3 and 4 tubes."""
    results = {}
    for needles, asked in ((2, 0.0), (3, 1e-3), (4, None)):
        row = follow_random(needles, count)
        row["asked_failed_share"] = asked
        row["general_path"] = solve_random_near(needles, count // 10)
        results[f"{needles} tubes"] = row
        print(f"random CRISP robots, {needles} tubes: {row}", flush=True)
    return results


def follow_random(needles, count) -> dict[str, Any]:
    """Return failures on `count` steps along edges to random targets, of robots of all joints."""
    done = failed = out_of_reach = folds = robots = 0
    worst = 0.0
    while done < count:
        chance = np.random.default_rng([needles, robots])
        joints = tuple(chance.choice(["rigid", "relaxed"], needles - 1).tolist())
        setup, first = random_crisp(chance, joints)
        targets = random_targets(chance, needles, 48)
        edges = edges_between(first, 0 * targets, targets)
        tracks = follow_crisp_edges(setup, edges, FOLLOW)
        wanted = np.arange(tracks.status.shape[1]) <= edges.steps[:, None]
        tried = wanted & (tracks.status != BEYOND)  # nothing is asked beyond the end of a branch
        short = (tracks.status == NO_SOLUTION) & tried
        fold = (tracks.status == BRANCH_ENDS) & tried
        done, robots = done + int(tried.sum()), robots + 1
        folds, out_of_reach = folds + int(fold.sum()), out_of_reach + int(short.sum())
        failed += int((tried & (tracks.status != SOLVED) & ~short & ~fold).sum())
        if robots <= 3:
            worst = max(worst, edge_error(setup, first, targets, edges, tracks, 3))
    return {
        "solves": done,
        "robots": robots,
        "failed": failed,
        "failed_share": failed / done,
        "out_of_reach": out_of_reach,
        "branch_ends": folds,
        "worst_error_mm": worst,
    }


def solve_random_near(needles: int, count: int) -> dict[str, Any]:
    """Return failures of the general path one step of 1 mm and 1 degree away from solutions of
    random robots, loaded and pre-curved."""
    failed = done = unsolved = robots = 0
    while done < count:
        chance = np.random.default_rng([needles, robots])
        joints = tuple(chance.choice(["rigid", "relaxed"], needles - 1).tolist())
        setup, first = random_crisp(chance, joints, robots % 3, robots % 2 == 1)
        robots += 1
        if solve_crisp(setup, first, SHAPE).status != "solved":
            unsolved += 1
            continue
        found, _ = solve_near(*near_by(setup, first, 48))
        done, failed = done + len(found), failed + int((found[:, 0] != SOLVED).sum())
    return {
        "solves": done,
        "failed": failed,
        "failed_share": failed / done,
        "robots": robots,
        "robots_unsolved_cold": unsolved,
    }
