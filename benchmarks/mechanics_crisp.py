"""CRISP robots: time and exactness of each path, cold and warm, with two and three tubes."""

import time
from typing import Any

import numpy as np

from benchmarks.mechanics_cases import random_crisp
from benchmarks.mechanics_edges import SHAPE, near_by, solve_near
from benchmarks.mechanics_peers import solve_crisp_plainly
from benchmarks.mechanics_straight import measure_straight, operations
from benchmarks.mechanics_timing import Row, cpu_us, show_head
from nodes.mechanics.crisp_edges import SOLVED
from nodes.mechanics.solve_crisp import solve_crisp
from tests.nodes.mechanics import oracle_crisp
from tests.nodes.mechanics.oracle_crisp_rods import robot_of

GENERAL = 3.5  # a residual with derivatives, in residuals without: 6 derivatives a rod


def run_crisp(repeats: int, flops: tuple[float, float]) -> dict[str, Any]:
    """Print and return the rows of two and three tubes on both paths."""
    show_head("CRISP robots, tip to 1e-6 mm, CPU time of one thread")
    rows: list[Row] = []
    for needles, asked in ((2, 10.0), (3, 25.0)):
        setup, first = random_crisp(np.random.default_rng(1), ("relaxed",) * (needles - 1))
        for row in [
            *measure_straight(setup, first, repeats, flops, asked),
            *measure_general(needles, repeats, flops),
            *measure_peer(setup, first),
        ]:
            row.show()
            rows.append(row)
    return {row.name: row.record() for row in rows}


def measure_general(needles, repeats, flops) -> list[Row]:
    """Return rows of the general path: loaded, pre-curved, and both, from the parent's solution."""
    rows = []
    for kind, loads, precurved in (
        ("straight", 0, False),
        ("loaded", 1, False),
        ("pre-curved", 0, True),
        ("loaded and pre-curved", 2, True),
    ):
        setup, first = random_crisp(
            np.random.default_rng(1), ("relaxed",) * (needles - 1), loads, precurved
        )
        us, error, failed = time_general(setup, first, repeats)
        residuals = 2 * GENERAL
        limit = operations(needles, residuals) / flops[1]
        note = f"{failed} of 200 failed" if failed else ""
        name = f"{needles} tubes, general path, {kind}"
        rows.append(Row(name, us, 100.0, limit, error, note))
        if kind == "loaded and pre-curved":
            us = cpu_us(lambda s=setup, c=first: solve_crisp(s, c, SHAPE), 1, 10)
            rows.append(Row(name + ", cold, from Python", us, note="all results"))
    return rows


def time_general(setup, first, repeats, count=200) -> tuple[float, float, int]:
    """Return us a solve of configurations 1 mm / 1 degree away from a solved one, the worst error
    of three tips in mm, and how many were not solved."""
    problem = near_by(setup, first, count)
    found, wrenches = solve_near(*problem)
    us = cpu_us(lambda: solve_near(*problem), count, repeats)
    worst = 0.0
    solved = np.flatnonzero(found[:, 0] == SOLVED)[:3]
    for row in solved:
        robot = robot_of(setup, problem[1][row])
        slow = oracle_crisp.polish(robot, wrenches[row])
        given = oracle_crisp.at_rest(robot, wrenches[row])
        worst = max(worst, float(np.abs(slow.tip_point - given.tip_point).max()))
    return us, worst, int((found[:, 0] != SOLVED).sum())


def measure_peer(setup, first) -> list[Row]:
    """Return what SciPy takes for a cold solve, as a person would write it."""
    robot = robot_of(setup, first)
    slow = oracle_crisp.polish(robot, solve_crisp(setup, first, SHAPE).base_wrenches)
    started = time.thread_time()
    plain = solve_crisp_plainly(robot, 0 * slow.base_wrenches, 1e-9)
    us = (time.thread_time() - started) * 1e6
    error = None if plain is None else float(np.abs(plain - slow.tip_point).max())
    name = f"{len(first.lengths_mm)} tubes, SciPy solve_ivp in root, cold"
    return [Row(name, us, tip_error_mm=error, note="same run, peer")]
