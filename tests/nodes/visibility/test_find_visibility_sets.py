"""Visibility sets of made trees: against one ray a cell, and what the table adds up."""

from dataclasses import replace

import numpy as np
import pytest

from nodes.geometry.lines_of_sight import find_surface, half_view, look_plainly
from nodes.geometry.origin import Origin
from nodes.mechanics.robots import CrispSetup
from nodes.planning.artefacts import CrispTree, CrispTrees, PlacedSetup
from nodes.visibility.find_visibility_sets import find_visibility_sets
from nodes.visibility.parameters import FindVisibilitySetsParameters
from tests.nodes.geometry.made_surfaces import ellipsoid, to_grid
from tests.nodes.mechanics.made_robots import crisp, poses

FREE = ellipsoid((14, 11, 9))
GRID = to_grid(FREE, np.diag([1.5, 1.5, 1.5, 1.0]))
ORIGIN = Origin("made trees", False, ("trees are made",))


def tree(name, seed, nodes, angle=80.0) -> CrispTree:
    rng = np.random.default_rng(seed)
    cells = np.argwhere(FREE)
    setup: CrispSetup = crisp(field_of_view_deg=angle)
    turns = np.zeros((3, 3)), np.ones(3), np.ones(3), np.full(3, 300.0)
    views = rng.normal(size=(nodes, 3))
    return CrispTree(
        PlacedSetup(name, setup, poses(), *turns),
        np.arange(nodes) - 1,
        np.tile([1.0, 0, 0, 0], (nodes, 3, 1)),
        np.full((nodes, 3), 100.0),
        np.ones(nodes, int),
        np.zeros((nodes, 3, 6)),
        cells[rng.integers(len(cells), size=nodes)] * 1.5,
        views / np.linalg.norm(views, axis=1)[:, None],
        np.arange(nodes) / 4,
        np.zeros(nodes, int),
        np.zeros(0, int),
        "node limit",
        (),
    )


@pytest.mark.parametrize("reading", ["own ray", "first hit"])
def test_sets_are_those_of_one_ray_a_cell_from_every_node(reading):
    grown = CrispTrees((tree("one", 0, 12), tree("two", 1, 9, 40.0)), ORIGIN)
    sets, _ = find_visibility_sets(grown, GRID, FindVisibilitySetsParameters(reading=reading))
    surface = find_surface(GRID)
    for one, grown_one in zip(sets.sets, grown.trees, strict=True):
        expected = np.full(len(surface.cells), -1)
        angle = half_view(grown_one.placed.setup.field_of_view_deg)
        view = grown_one.cameras_patient_mm, grown_one.views, angle
        look_plainly(surface, view, reading, 0, expected)
        np.testing.assert_array_equal(one.first_nodes, expected)
        np.testing.assert_array_equal(one.seconds, grown_one.seconds)
    np.testing.assert_array_equal(sets.cells, np.argwhere(GRID.mask("boundary")))
    assert sets.reading == reading and sets.shape == GRID.voxels.shape


def test_the_table_counts_each_set_and_their_union():
    grown = CrispTrees((tree("one", 0, 12), tree("two", 1, 9)), ORIGIN)
    sets, table = find_visibility_sets(grown, GRID, FindVisibilitySetsParameters(reading="own ray"))
    seen = [one.first_nodes >= 0 for one in sets.sets]
    counts = [seen[0].sum(), seen[1].sum(), (seen[0] | seen[1]).sum()]
    assert table["name"].tolist() == ["one", "two", "union"]
    assert table["cells_seen"].tolist() == counts and counts[2] > max(counts[:2])
    np.testing.assert_allclose(table["share_seen"], np.array(counts) / len(sets.cells))
    assert table["nodes"].tolist() == [12, 9, 21]
    assert table["seconds"].tolist() == [2.75, 2.0, 2.75]
    np.testing.assert_allclose(table["nodes_per_hour"][:2], [12 * 3600 / 2.75, 9 * 3600 / 2.0])


def test_what_a_reader_must_know_is_told():
    grown = CrispTrees((tree("one", 0, 3), tree("two", 1, 3, 40.0)), ORIGIN)
    sets, _ = find_visibility_sets(grown, GRID, FindVisibilitySetsParameters(reading="own ray"))
    told = sets.origin
    assert told.simulated and {"trees are made", "n"} <= set(told.notices)
    assert any("40 degrees" in one for one in told.notices)
    assert any("80 degrees" in one for one in told.notices)


def test_no_trees_and_a_tree_of_the_start_alone_make_a_table():
    parameters = FindVisibilitySetsParameters(reading="own ray")
    none, table = find_visibility_sets(CrispTrees((), ORIGIN), GRID, parameters)
    assert none.sets == () and table["cells_seen"].tolist() == [0]
    alone = CrispTrees((replace(tree("one", 0, 1), seconds=np.zeros(1)),), ORIGIN)
    _, table = find_visibility_sets(alone, GRID, parameters)
    assert table["cells_seen"][0] == table["cells_seen"][1] and table["nodes_per_hour"].isna().all()


def test_cameras_outside_of_free_cells_are_counted():
    lost = tree("one", 0, 3)
    lost = replace(lost, cameras_patient_mm=lost.cameras_patient_mm * [[1.0], [99.0], [0.0]])
    parameters = FindVisibilitySetsParameters(reading="own ray")
    sets, _ = find_visibility_sets(CrispTrees((lost,), ORIGIN), GRID, parameters)
    assert set(sets.sets[0].first_nodes.tolist()) == {-1, 0}
    assert any(one.startswith("2 nodes") for one in sets.origin.notices)
