"""What compiling all kernels of mechanics costs, and how soon they are ready from the cache."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ASKED_CPU_S, ASKED_READY_S = 90.0, 1.5
BARE = "import numpy, numba, nodes.mechanics.robots"
CONCENTRIC = """
import numpy as np
from benchmarks.mechanics_cases import random_concentric_configuration, random_concentric_robot
from nodes.mechanics.solve_concentric_tubes import solve_concentric_tubes
for tubes in {tubes}:
    chance = np.random.default_rng(tubes)
    robot = random_concentric_robot(chance, tubes)
    solve_concentric_tubes(robot, random_concentric_configuration(chance, robot))
"""
STRAIGHT = """
import numpy as np
from benchmarks.mechanics_cases import random_crisp
from benchmarks.mechanics_edges import FOLLOW, edges_between, random_targets
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
setup, first = random_crisp(np.random.default_rng(1), ("relaxed",))
targets = random_targets(np.random.default_rng(1), 2, 2)
follow_crisp_edges(setup, edges_between(first, 0 * targets, targets), FOLLOW)
"""
GENERAL = """
import numpy as np
from benchmarks.mechanics_cases import random_crisp
from benchmarks.mechanics_edges import SHAPE
from nodes.mechanics.crisp_jacobians import crisp_jacobians
from nodes.mechanics.solve_crisp import solve_crisp
setup, first = random_crisp(np.random.default_rng(1), ("relaxed",), 1, True)
found = solve_crisp(setup, first, SHAPE)
{jacobians}
"""
JACOBIANS = "crisp_jacobians(setup, first, found.base_wrenches, 1e-6)"
PARTS = {
    "concentric tubes, 2": CONCENTRIC.format(tubes=(2,)),
    "concentric tubes, 3": CONCENTRIC.format(tubes=(3,)),
    "concentric tubes, 4": CONCENTRIC.format(tubes=(4,)),
    "CRISP, straight": STRAIGHT,
    "CRISP, general": GENERAL.format(jacobians=""),
    "CRISP, Jacobians": GENERAL.format(jacobians=JACOBIANS),
}


def run_compile(root: Path) -> dict[str, Any]:
    """Compile part after part into an empty folder, then start each again from it."""
    rows: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        bare = run_python(root, BARE, folder)
        for name, program in PARTS.items():
            cold = run_python(root, program, folder)
            warm = min((run_python(root, program, folder) for _ in range(3)), key=lambda w: w["s"])
            rows[name] = {
                "cold_cpu_s": cold["cpu_s"] - bare["cpu_s"],
                "ready_s": warm["s"],
                "ready_cpu_s": warm["cpu_s"],
            }
            show(name, rows[name])
    whole = sum(row["cold_cpu_s"] for row in rows.values())
    rows["everything, cold"] = {"cpu_s": whole, "asked_cpu_s": ASKED_CPU_S}
    rows["Python and Numba alone"] = bare
    rows["slowest part from the cache"] = {
        "ready_s": max(row["ready_s"] for row in rows.values() if "ready_s" in row),
        "asked_s": ASKED_READY_S,
    }
    for name in list(rows)[-3:]:
        show(name, rows[name])
    return rows


def run_python(root: Path, program: str, cache: str) -> dict[str, float]:
    """Run a program in a process of its own; return wall and CPU seconds."""
    environment = os.environ | {"NUMBA_CACHE_DIR": cache}
    started = time.perf_counter()
    process = subprocess.Popen([sys.executable, "-c", program], cwd=root, env=environment)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"this failed:\n{program}")
    return {"s": time.perf_counter() - started, "cpu_s": usage.ru_utime + usage.ru_stime}


def show(name: str, row: dict[str, float]) -> None:
    print(f"{name:30}  {'  '.join(f'{key} {value:.2f}' for key, value in row.items())}", flush=True)
