"""Trees of set-ups at equal time, with solves seeded in several ways [Kuntz2017] Sec. V-A, V-C."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from nodes.geometry.grids import LabelMap, Volume
from nodes.planning.artefacts import CrispTree, CrispTrees, PlacedSetup, PlacedSetups
from nodes.planning.cavity import make_cavity, make_wall
from nodes.planning.parameters import GrowStudyTreesParameters
from nodes.planning.tree_growth import grow_tree

if TYPE_CHECKING:
    import pandas

COUNTED = {
    "steps_solved": "steps solved",
    "iterations": "iterations",
    "failures": "steps without a solution",
}
"""Columns and the counts of trees that they hold."""

HOUR_S = 3600.0
NO_GOALS = np.zeros((0, 3), int)


def grow_study_trees(
    placed_setups: PlacedSetups,
    occupancy_grid: LabelMap,
    distance_field: Volume,
    label_map: LabelMap,
    parameters: GrowStudyTreesParameters,
) -> tuple[CrispTrees, "pandas.DataFrame"]:
    """Grow one tree for each set-up and each way to seed its solves, all for equal time.

    Returns
    -------
    crisp_trees : named "<set-up>, from <seed>".
    seeding_table : one row a tree: `name`, `setup`, `seeding` ("parent", "start", "zero"), `nodes`,
        `nodes_per_hour` (of all trees that grow side by side), `steps_solved`, `iterations`,
        `failures` (edges that ended since a step was not solved), `seconds`.

    Raises
    ------
    BadInput as grow_crisp_trees.
    """
    import pandas

    cavity = make_cavity(occupancy_grid, distance_field)
    wall = make_wall(label_map, parameters.sheath_avoids)
    trees, rows = [], []
    for seeding in (parameters.seed_from, *parameters.compared_with):
        chosen = parameters.model_copy(update={"seed_from": seeding})
        for placed in placed_setups.setups:
            named = replace(placed, name=f"{placed.name}, from {seeding}")
            tree = grow_tree(named, cavity, wall, NO_GOALS, chosen)
            trees.append(tree)
            rows.append(_tell(tree, placed, seeding))
    origin = placed_setups.origin.with_notice(*occupancy_grid.origin.notices)
    simulated = origin.simulated or occupancy_grid.origin.simulated
    return CrispTrees(tuple(trees), replace(origin, simulated=simulated)), pandas.DataFrame(rows)


def _tell(tree: CrispTree, placed: PlacedSetup, seeding: str) -> dict[str, object]:
    counts = {figure.name: figure.value for figure in tree.counts}
    nodes, seconds = len(tree.parents), float(tree.seconds[-1])
    return {
        "name": tree.placed.name,
        "setup": placed.name,
        "seeding": seeding,
        "nodes": nodes,
        "nodes_per_hour": nodes * HOUR_S / seconds if seconds > 0 else np.nan,
        **{column: int(counts[name]) for column, name in COUNTED.items()},
        "seconds": seconds,
    }
