"""How long until there is a plan to a random goal on the surface of the ellipsoid.

A tree grows until a node sees the goal, and the way there is shortened, smoothed and verified. The
goals are cells of the surface that a tree of many nodes sees. All is compiled before; the times are
those on the clock, with two trees at once.
"""

import statistics
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.crisp_planning_trees import Place, grow, made_setup, make_place
from catalog.yaml_file import load_mapping
from nodes.geometry.origin import Origin
from nodes.planning.artefacts import CrispTrees, Goals, PlacedSetup
from nodes.planning.parameters import PlanCrispMotionsParameters
from nodes.planning.plan_crisp_motions import plan_crisp_motions

DEFAULTS = Path(__file__).resolve().parent.parent / "catalog/parameters/plan_crisp_motions.yml"
WANTED_S = 1.0
MADE = Origin("an ellipsoid", simulated=True)
SEEN_BY = 40_000  # nodes of the tree that tells which cells can be seen


def run_plans(goals: int) -> tuple[list[str], dict[str, Any]]:
    """Return lines of a table, and the same as data."""
    place, placed = make_place(), made_setup(1)
    cells, share = _find_visible(place, placed, goals)
    _plan(place, placed, cells[0])
    grown, planned, found = [], [], 0
    for cell in cells:
        seen_s, plan_s, is_planned = _plan(place, placed, cell)
        grown.append(seen_s)
        planned.append(plan_s)
        found += is_planned
    median, seen = statistics.median(planned), statistics.median(grown)
    met = "yes" if median < WANTED_S else "NO"
    line = (
        f"first plan to each of {len(cells)} goals: median {median:.3f} s, of which {seen:.3f} s"
        f" until it is seen; longest {max(planned):.2f} s; {found} planned; below 1 s: {met}"
    )
    return [line], {
        "goals": len(cells), "planned": found, "median_s": median, "median_seen_s": seen,
        "longest_s": max(planned), "visible_share": share,
    }  # fmt: skip


def _find_visible(place: Place, placed: PlacedSetup, goals: int) -> tuple[np.ndarray, float]:
    boundary = np.argwhere(place.grid.mask("boundary"))
    chance = np.random.default_rng(1)
    cells = boundary[chance.choice(len(boundary), 2 * goals, replace=False)]
    whole = grow(place, placed, {"node_limit": SEEN_BY, "trees": 2}, cells)
    return cells[whole.seeing >= 0][:goals], float((whole.seeing >= 0).mean())


def _plan(place: Place, placed: PlacedSetup, cell: np.ndarray) -> tuple[float, float, bool]:
    """Return when the goal was seen and when there was a plan, s, and whether there is one."""
    point = place.grid.patient_from_index[:3] @ np.append(cell, 1.0)
    goal = Goals(("goal",), cell[None], np.zeros(1, int), point[None], MADE)
    chosen = PlanCrispMotionsParameters(**(load_mapping(DEFAULTS) | {"sheath_avoids": ()}))
    began = time.perf_counter()
    changed = {"node_limit": 10 * SEEN_BY, "trees": 2, "stop_when_seen": True}
    trees = CrispTrees((grow(place, placed, changed, cell[None]),), MADE)
    seen_s = time.perf_counter() - began
    plans = plan_crisp_motions(trees, place.grid, place.distances, place.grid, goal, chosen)
    return seen_s, time.perf_counter() - began, plans.plans[0].status == "planned"
