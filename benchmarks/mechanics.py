"""How fast and how exact are the mechanics, and do they ever fail?

Concentric tubes and CRISP robots, cold, warm and along edges, beside what was asked, an estimated
limit and plain SciPy; the compilation of all kernels; 100,000 random concentric tubes and 10,000
steps of random CRISP robots. The limit is a hand count of a solve's operations over what this core
does in the same run, in whole vectors or, on CRISP's general path, one number at a time: good to
its order of magnitude.

    python -m benchmarks.mechanics [--only concentric crisp compile random] [--repeats 15]
"""

import argparse
import json
from pathlib import Path
from typing import Any

from pipelines.kernel_cache import use_kernel_cache

ROOT = Path(__file__).resolve().parent.parent
use_kernel_cache(ROOT)  # before anything imports Numba

from benchmarks.mechanics_compile import run_compile  # noqa: E402
from benchmarks.mechanics_concentric import run_concentric, run_random_concentric  # noqa: E402
from benchmarks.mechanics_crisp import run_crisp  # noqa: E402
from benchmarks.mechanics_random import run_random_crisp  # noqa: E402
from benchmarks.mechanics_timing import flops_per_us  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--configurations", type=int, default=100_000)
    parser.add_argument("--steps", type=int, default=10_000)
    kinds = ["concentric", "crisp", "compile", "random"]
    parser.add_argument("--only", nargs="+", default=kinds, choices=kinds)
    chosen = parser.parse_args()
    results: dict[str, Any] = {}
    if "compile" in chosen.only:
        results["compile"] = run_compile(ROOT)
    flops = flops_per_us()
    results["giga_operations_per_s"] = {"vectors": flops[0] / 1e3, "single": flops[1] / 1e3}
    if "concentric" in chosen.only:
        results["concentric"] = run_concentric(chosen.repeats, flops)
    if "crisp" in chosen.only:
        results["crisp"] = run_crisp(chosen.repeats, flops)
    if "random" in chosen.only:
        results["random_concentric"] = run_random_concentric(chosen.configurations)
        results["random_crisp"] = run_random_crisp(chosen.steps)
    print(json.dumps(results))


if __name__ == "__main__":
    main()
