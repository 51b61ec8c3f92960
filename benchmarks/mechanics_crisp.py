"""CRISP robots: time and exactness of each path, cold and warm, with two and three tubes."""

import time
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.mechanics_cases import random_crisp
from benchmarks.mechanics_edges import (
    FOLLOW,
    SHAPE,
    edge_error,
    edges_between,
    ends_of,
    near_by,
    random_targets,
    solve_near,
)
from benchmarks.mechanics_peers import solve_crisp_plainly
from benchmarks.mechanics_timing import Row, cpu_us, show_head
from nodes.mechanics.crisp_edges import SOLVED, CrispEdges
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.solve_crisp import solve_crisp
from tests.nodes.mechanics import oracle_crisp
from tests.nodes.mechanics.oracle_crisp_rods import robot_of

COUNT, STEPS = 960, 10  # edges in a batch, steps of 1 mm and 1 degree along each
CPP_MARK_US = 1e6 / 246_000  # chord iteration in C++, one core, two tubes

# Multiplications and additions of one residual of straight robots: a rod's two steps of order 8 in
# place and frame, and a joint. A warm solve needs one residual and one chord update at least, a
# cold one four with derivatives. The general path carries 6 derivatives a rod.
ROD, JOINT, CHORD = 2 * 12 * 60, 120, 72
GENERAL = 3.5  # a residual with derivatives, in residuals without


def operations(needles: int, residuals: float) -> float:
    """Return how many operations so many residuals of straight robots take."""
    rods = (2 * needles - 1) * ROD
    joints = (needles - 1) * JOINT
    return residuals * (rods + joints + CHORD * (needles - 1) ** 2)


def run_crisp(
    repeats: int,
    flops: tuple[float, float],
) -> dict[str, Any]:
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


def measure_straight(setup, first, repeats, flops, asked) -> list[Row]:
    """Return rows of the lanes' path: along edges, from the parent's solution, cold, one call."""
    needles = len(first.lengths_mm)
    name = f"{needles} tubes, straight, "
    chance = np.random.default_rng(7)
    starts, ends = (random_targets(chance, needles, COUNT) for _ in range(2))
    arrive = edges_between(first, 0 * starts, starts)
    seeds = ends_of(arrive, follow_crisp_edges(setup, arrive, FOLLOW))
    kept = ~np.isnan(seeds).any((1, 2))
    starts, ends, seeds = starts[kept], ends[kept], seeds[kept]
    way = ends - starts
    largest = np.maximum(np.linalg.norm(way[..., :3], axis=2), np.abs(way[..., 3])).max(1)
    step = way / largest[:, None, None]  # 1 mm or 1 degree
    near, ends = starts + step, starts + STEPS * step
    here = replace(edges_between(first, starts, starts, 0), start_wrenches=seeds)
    long = replace(edges_between(first, starts, ends, STEPS), start_wrenches=seeds)
    short = replace(edges_between(first, starts, near, 1), start_wrenches=seeds)
    cold = edges_between(first, starts, starts, 0)
    tracks = follow_crisp_edges(setup, long, FOLLOW)
    error = edge_error(setup, first, ends, long, tracks)
    lost = int((tracks.status != SOLVED).sum())
    cold_error = edge_error(setup, first, starts, cold, follow_crisp_edges(setup, cold, FOLLOW))

    def time_of(edges: CrispEdges) -> float:
        return cpu_us(lambda: follow_crisp_edges(setup, edges, FOLLOW), len(starts), repeats)

    base = time_of(here)
    along = (time_of(long) - base) / STEPS
    mark = CPP_MARK_US if needles == 2 else None
    one = replace(
        edges_between(first, starts[:1], near[:1], 1),
        start_wrenches=np.ascontiguousarray(seeds[:1]),
    )
    note = f"{len(starts)} edges of {STEPS} steps, {lost} not solved"
    wide = flops[0]
    rows = [
        Row(name + "along edges", along, asked, operations(needles, 2) / wide, error, note),
        Row(
            name + "parent's solution", time_of(short) - base, asked, operations(needles, 3) / wide
        ),
        Row(name + "start given, checked", base, None, operations(needles, 1) / wide),
        Row(
            name + "cold, 8 deg / 4 mm",
            time_of(cold),
            None,
            operations(needles, 12) / wide,
            cold_error,
        ),
        Row(
            name + "one edge of one step from Python",
            cpu_us(lambda: follow_crisp_edges(setup, one, FOLLOW), 1, 50),
        ),
    ]
    whole = base / STEPS + along
    rows.insert(1, Row(name + "the same with starts, against C++", whole, mark))
    return rows


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
