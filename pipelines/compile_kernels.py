"""Compiles what planning and its check need, on two cores, so that no first run waits for it.

It is done by doing it: a plan in a made box, and a check of it, each in a process of its own.
"""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from catalog.yaml_file import load_mapping
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from pipelines.kernel_cache import use_kernel_cache

ROOT = Path(__file__).resolve().parent.parent
SIDE = 60  # cells of 1 mm along each side of the box
MADE = Origin("a made box", simulated=True)


@dataclass
class Box:
    """A box whose walls a tool and a snare pass at right angles."""

    occupancy_grid: LabelMap
    label_map: LabelMap
    placed_setups: Any
    goals: Any


def main() -> None:
    """Compile in two processes."""
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        for done in [pool.submit(compile_planning), pool.submit(compile_check)]:
            done.result()


def compile_planning() -> None:
    """Grow a small tree, look from its nodes, and plan to what one sees."""
    use_kernel_cache(ROOT)
    from nodes.environment.measure_distance import measure_distance
    from nodes.planning.grow_crisp_trees import grow_crisp_trees
    from nodes.planning.parameters import GrowCrispTreesParameters, PlanCrispMotionsParameters
    from nodes.planning.plan_crisp_motions import plan_crisp_motions
    from nodes.visibility.find_visibility_sets import find_visibility_sets
    from nodes.visibility.parameters import FindVisibilitySetsParameters

    box = make_box()
    field = measure_distance(box.occupancy_grid)
    how = GrowCrispTreesParameters(**defaults("grow_crisp_trees") | {"node_limit": 100})
    trees = grow_crisp_trees(
        box.placed_setups, box.occupancy_grid, field, box.label_map, box.goals, how
    )
    looking = FindVisibilitySetsParameters(**defaults("find_visibility_sets"))
    find_visibility_sets(trees, box.occupancy_grid, looking)
    planning = PlanCrispMotionsParameters(**defaults("plan_crisp_motions"))
    plan_crisp_motions(trees, box.occupancy_grid, field, box.label_map, box.goals, planning)


def compile_check() -> None:
    """Check a motion that stays at its start."""
    use_kernel_cache(ROOT)
    from nodes.planning.artefacts import CrispMotion, MotionPlan, MotionPlans
    from nodes.planning.check_crisp_plans import check_crisp_plans
    from nodes.planning.parameters import CheckCrispPlansParameters

    box = make_box()
    placed = box.placed_setups.setups[0]
    frames, lengths = placed.start.patient_from_entry, placed.start.lengths_mm
    camera = np.eye(4)
    camera[:3, :3] = frames[0]
    camera[:3, 3] = placed.setup.entry_points_patient_mm[0] + lengths[0] * frames[0, :, 2]
    twice = CrispMotion(*(np.stack([a, a]) for a in (frames, lengths, np.zeros((2, 6)), camera)))
    plan = MotionPlan(
        box.goals.names[0], box.goals.points_patient_mm[0], box.goals.cells, placed, "planned", "",
        twice, (),
    )  # fmt: skip
    checking = CheckCrispPlansParameters(**defaults("check_crisp_plans"))
    plans = MotionPlans((plan,), MADE)
    check_crisp_plans(plans, box.goals, box.occupancy_grid, box.label_map, checking)


def make_box() -> Box:
    """Return a box with a robot at rest in it, and a goal before its camera."""
    from nodes.mechanics.materials import MATERIALS
    from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Needle, Snare
    from nodes.planning.artefacts import Goals, PlacedSetup, PlacedSetups
    from nodes.planning.setup_starts import roll_needles

    cells = np.zeros((SIDE + 2,) * 3, np.uint8)
    cells[:] = 2
    cells[1:-1, 1:-1, 1:-1] = 1
    middle, wall = SIDE / 2 + 0.5, 0.5
    entries = np.array([[wall, middle, middle], [middle, wall, middle]])
    axes = np.eye(3)[:2]
    needle = Needle(MATERIALS["nitinol"], 0.84, 1.02, np.zeros(3))
    setup = CrispSetup((needle, needle), entries, (Snare(1, 10.0, joint="rigid"),), 90.0)
    frames = np.concatenate(roll_needles(axes[:1], axes[1:]))
    start = CrispConfiguration(frames, np.array([middle - wall + 10, middle - wall]))
    placed = PlacedSetup(
        "made", setup, start, axes, np.full(2, 1.0), np.full(2, 15.0), np.full(2, 50.0)
    )
    goal = np.array([[SIDE + 1, SIDE // 2, SIDE // 2]])
    return Box(
        LabelMap(cells, np.eye(4), ("free", "boundary"), MADE),
        LabelMap(np.zeros_like(cells), np.eye(4), ("bone",), MADE),
        PlacedSetups((placed,), MADE),
        Goals(("made",), goal, np.zeros(1, int), goal.astype(float), MADE),
    )


def defaults(stage: str) -> dict[str, Any]:
    """Return a stage's default parameters."""
    return dict(load_mapping(ROOT / "catalog" / "parameters" / f"{stage}.yml"))


if __name__ == "__main__":
    main()
