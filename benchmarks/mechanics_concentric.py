"""Concentric tubes: time of a solve as compiled code does many, and how exact it is."""

import time
from typing import Any

import numpy as np

from benchmarks.mechanics_cases import (
    DUO,
    TRIO,
    concentric_robot,
    random_concentric_robot,
    random_insertion,
)
from benchmarks.mechanics_peers import solve_concentric_plainly
from benchmarks.mechanics_timing import Row, cpu_us, show_head
from nodes.mechanics.robots import ConcentricTubeConfiguration, ConcentricTubeRobot
from nodes.mechanics.solve_concentric_tube_batch import solve_concentric_tube_batch
from nodes.mechanics.solve_concentric_tubes import solve_concentric_tubes
from tests.nodes.mechanics import oracle_concentric_tubes as oracle

COUNT = 1000  # configurations a batch
SAMPLES = 50

# Multiplications and additions of one solve: torsion with n - 1 columns in coarse steps of order 4
# and fine ones of order 8, pose, samples, counted from the formulae for the sections of a robot
# fully out. A limit for code that goes one number at a time, and for whole vectors.
ACCELERATION = {2: 55, 3: 130, 4: 250}
STATE = {2: 2, 3: 6, 4: 12}
COUPLED, COARSE, FINE, STEPS = 3, 2, 1, 5
POSE_STEP, SAMPLE, JACOBIAN_STEP = 550, 60, 500


def operations(tubes: int, samples: int, jacobian: bool) -> float:
    """Return how many operations one cold solve needs at least."""
    coarse = 3 * ACCELERATION[tubes] + 16 * STATE[tubes]
    fine = 8 * ACCELERATION[tubes] + 2 * (28 + 8 + 14) * STATE[tubes]
    torsion = COUPLED * (COARSE * coarse + FINE * fine)
    return torsion + STEPS * (POSE_STEP + JACOBIAN_STEP * jacobian) + SAMPLE * samples


def unique_joints(
    chance: np.random.Generator, robot: ConcentricTubeRobot, count: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return rotations and translations at insertions with one solution; None if they are rare."""
    rotations = chance.uniform(-np.pi, np.pi, (4 * count, len(robot.tubes)))
    translations = np.array([random_insertion(chance, robot) for _ in range(4 * count)])
    batch = solve_concentric_tube_batch(robot, rotations, translations, with_uniqueness=True)
    kept = np.flatnonzero(batch.one_solution)[:count]
    return (rotations[kept], translations[kept]) if len(kept) == count else None


def run_concentric(repeats: int, flops: tuple[float, float]) -> dict[str, Any]:
    """Print and return the rows of 2, 3 and 4 tubes."""
    show_head("Concentric tubes, tip to 1e-6 mm, CPU time of one thread")
    rows: list[Row] = []
    chance = np.random.default_rng(4)
    for robot in (
        concentric_robot(DUO),
        concentric_robot(TRIO),
        random_concentric_robot(chance, 4),
    ):
        rotations, translations = unique_joints(chance, robot, COUNT)
        for row in measure_robot(robot, rotations, translations, repeats, flops):
            row.show()
            rows.append(row)
        for row in measure_peers(robot, rotations, translations):
            row.show()
            rows.append(row)
    return {row.name: row.record() for row in rows}


def measure_robot(robot, rotations, translations, repeats, flops) -> list[Row]:
    """Return the rows of one robot: cold and warm, with and without samples and Jacobian."""
    tubes, count = len(robot.tubes), len(rotations)
    error = worst_error(robot, rotations[:8], translations[:8])
    asked = {"cold, 50 samples": 3.5, "cold, 50 samples, Jacobian": 6.5, "cold": 2.0}
    cold = solve_concentric_tube_batch(robot, rotations, translations)
    near = cold.tip_angles_rad
    rng = np.random.default_rng(0)
    moved = rotations + rng.uniform(-1, 1, rotations.shape) * np.radians(1.0)
    kinds = [
        ("cold", rotations, None, 0, False),
        ("cold, 50 samples", rotations, None, SAMPLES, False),
        ("cold, 50 samples, Jacobian", rotations, None, SAMPLES, True),
        ("warm, 1 degree away", moved, near, 0, False),
        ("warm, 50 samples", moved, near, SAMPLES, False),
    ]
    rows = []
    for name, turned, start, samples, jacobian in kinds:
        us = cpu_us(
            lambda turned=turned, start=start, samples=samples, jacobian=jacobian: (
                solve_concentric_tube_batch(
                    robot, turned, translations, start, samples, False, jacobian
                )
            ),
            count,
            repeats,
        )
        limit = operations(tubes, samples, jacobian) / flops[0]
        goal = asked.get(name) if tubes == 3 else None
        rows.append(Row(f"{tubes} tubes, {name}", us, goal, limit, error, f"batch of {count}"))
    single = ConcentricTubeConfiguration(rotations[0], translations[0])
    us = cpu_us(lambda: solve_concentric_tubes(robot, single), 1, 50)
    rows.append(Row(f"{tubes} tubes, one call from Python, all results", us))
    return rows


def measure_peers(robot, rotations, translations, count: int = 4) -> list[Row]:
    """Return what SciPy takes, as a person would write it and as the oracle has it."""
    ways = [
        ConcentricTubeConfiguration(*one)
        for one in zip(rotations[:count], translations[:count], strict=True)
    ]
    tips = [oracle.solve(robot, one).tip_point for one in ways]
    started = time.thread_time()
    plain = [solve_concentric_plainly(robot, one, 1e-8) for one in ways]
    us = (time.thread_time() - started) / count * 1e6
    found = [np.abs(a - b).max() for a, b in zip(plain, tips, strict=True) if a is not None]
    name = f"{len(robot.tubes)} tubes, SciPy solve_ivp in root"
    return [Row(name, us, tip_error_mm=float(max(found)), note="same run, peer")]


def worst_error(robot, rotations, translations) -> float:
    """Return the largest distance of tips and 50 samples from the oracle's, mm."""
    batch = solve_concentric_tube_batch(robot, rotations, translations, samples=SAMPLES)
    base, worst = robot.patient_from_base, 0.0
    for row, joints in enumerate(zip(rotations, translations, strict=True)):
        slow = oracle.solve(robot, ConcentricTubeConfiguration(*joints))
        points = slow.points(batch.arc_lengths_mm[row]) @ base[:3, :3].T + base[:3, 3]
        worst = max(worst, np.abs(points - batch.points_patient_mm[row]).max())
    return float(worst)


def run_random_concentric(count: int, checked: int = 6) -> dict[str, Any]:
    """Solve many random configurations at insertions with one solution; count what fails."""
    chance, failed, done, worst = np.random.default_rng(99), 0, 0, 0.0
    unsolved: list[dict[str, Any]] = []
    started = time.thread_time()
    size = 500
    while done < count:
        tubes = 2 + done // size % 3
        robot = random_concentric_robot(chance, tubes)
        joints = unique_joints(chance, robot, size)
        if joints is None:
            continue
        rotations, translations = joints
        batch = solve_concentric_tube_batch(robot, rotations, translations)
        bad = np.flatnonzero(batch.status != 0)
        failed, done = failed + len(bad), done + size
        unsolved += [{"tubes": tubes, "status": int(batch.status[row])} for row in bad[:3]]
        if done <= checked * size:
            worst = max(worst, worst_error(robot, rotations[:4], translations[:4]))
    row = {
        "configurations": done,
        "failed": failed,
        "asked_failed": 0,
        "worst_error_mm": worst,
        "checked_against_oracle": 4 * checked,
        "cpu_s": time.thread_time() - started,
        "unsolved": unsolved[:5],
    }
    print(f"\nrandom concentric tubes: {row}", flush=True)
    return row
