"""The table of trees that are compared at equal time, in the small ellipsoid of other tests."""

import pytest

from nodes.planning.artefacts import PlacedSetups
from nodes.planning.grow_study_trees import grow_study_trees
from nodes.planning.parameters import GrowStudyTreesParameters
from tests.nodes.planning.test_grow_crisp_trees import BONE, FIELD, GRID, HERE, parameters, placed

SEEDS = ("parent", "start", "zero")
NODES = 30


@pytest.fixture(scope="module")
def grown():
    asked = parameters(node_limit=NODES, trees=1).model_dump() | {"compared_with": SEEDS[1:]}
    setups = PlacedSetups((placed(),), HERE)
    return grow_study_trees(setups, GRID, FIELD, BONE, GrowStudyTreesParameters(**asked))


def test_each_way_to_seed_has_a_tree_and_a_row(grown):
    trees, table = grown
    assert table["seeding"].tolist() == list(SEEDS)
    assert table["name"].tolist() == [tree.placed.name for tree in trees.trees]
    assert (table["setup"] == "made").all() and (table["nodes"] == NODES).all()
    hours = table["seconds"] / 3600
    assert table["nodes_per_hour"].to_numpy() == pytest.approx(NODES / hours)


def test_seeds_farther_away_cost_more_iterations(grown):
    _, table = grown
    rows = table.set_index("seeding")
    assert (rows["iterations"] >= rows["steps_solved"] // 2).all()
    each = rows["iterations"] / rows["steps_solved"]
    assert each["start"] > each["parent"] and each["zero"] > each["parent"]


def test_steps_of_all_edges_were_solved(grown):
    trees, table = grown
    for tree, solved, failures in zip(
        trees.trees, table["steps_solved"], table["failures"], strict=True
    ):
        assert solved >= tree.steps.sum() and failures >= 0
