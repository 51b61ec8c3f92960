"""How fast are motions of CRISP robots planned: trees, nearest neighbours, views, first plans?

    python -m benchmarks.crisp_planning [--only trees plans views] [--nodes 100000] [--repeats 3]

Prints tables and, last, one JSON object. Figures are medians over repeats.
"""

import argparse
import json
from pathlib import Path
from typing import Any

from pipelines.kernel_cache import use_kernel_cache

use_kernel_cache(Path(__file__).resolve().parent.parent)  # before anything imports Numba

from benchmarks.crisp_planning_plans import run_plans  # noqa: E402
from benchmarks.crisp_planning_trees import run_trees  # noqa: E402
from benchmarks.crisp_planning_views import run_views  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    kinds = ["trees", "plans", "views"]
    parser.add_argument("--only", nargs="+", default=kinds, choices=kinds)
    parser.add_argument("--nodes", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--goals", type=int, default=40)
    chosen = parser.parse_args()
    results: dict[str, Any] = {}
    if "trees" in chosen.only:
        lines, results["trees"] = run_trees(chosen.nodes, chosen.repeats)
        print(*lines, sep="\n", flush=True)
    if "plans" in chosen.only:
        lines, results["first_plan"] = run_plans(chosen.goals)
        print(*lines, sep="\n", flush=True)
    if "views" in chosen.only:
        lines, results["views"] = run_views(repeats=chosen.repeats)
        print(*lines, sep="\n")
    print(json.dumps(results))


if __name__ == "__main__":
    main()
