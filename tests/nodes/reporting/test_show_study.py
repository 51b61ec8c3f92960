import numpy as np
import pandas as pd
import pytest

from nodes.reporting.show_study import (
    compare_nodes,
    compare_shares,
    compare_terms,
    show_study,
    tell_runs,
)
from tests.nodes.reporting import made_plans


@pytest.fixture
def table():
    return pd.DataFrame({
        "name": ["1 parent", "2 parent", "1 start", "2 start", "union", "union"],
        "setup": ["set-up 1", "set-up 2", "set-up 1", "set-up 2", "union", "union"],
        "seeding": ["parent", "parent", "start", "start", "parent", "start"],
        "share_seen": [0.41, 0.5, 0.4, 0.45, 0.7, 0.6],
        "nodes": [10000, 12000, 4000, 3000, 22000, 7000],
        "nodes_per_hour": [1.2e6, 1.44e6, 4.8e5, 3.6e5, np.nan, np.nan],
        "seconds": [30.0] * 6,
    })  # fmt: skip


def show(table, sets, defaults):
    return show_study(table, sets, made_plans.make_trees("1 parent"), defaults("show_study"))


def test_the_papers_shares_stand_beside_ours(table, defaults):
    shares = compare_shares(table, defaults("show_study"))
    assert shares["set-up"].tolist() == ["set-up 1", "set-up 2", "union"]
    assert shares["paper_percent"].tolist() == [38, 57, 80]
    assert shares["here_percent"].tolist() == pytest.approx([41, 50, 70])
    assert shares["paper, seeded by the start_percent"].tolist()[:2] == [30, 38]


def test_the_ratios_of_nodes_are_what_was_counted(table, defaults):
    nodes = compare_nodes(table, defaults("show_study"))
    assert nodes["paper, ratio"].tolist() == pytest.approx([37855 / 2177, 36610 / 2627])
    assert nodes["here, ratio"].tolist() == pytest.approx([2.5, 4.0])
    assert nodes["here, nodes an hour"].tolist() == [1_200_000, 1_440_000]


def test_more_set_ups_than_the_paper_had_have_no_figure_of_the_paper(table, defaults):
    third = table.head(1).assign(setup="set-up 3", share_seen=0.2)
    shares = compare_shares(pd.concat([table, third]), defaults("show_study"))
    row = shares[shares["set-up"] == "set-up 3"].iloc[0]
    assert np.isnan(row["paper_percent"]) and row["here_percent"] == pytest.approx(20)


def test_a_run_that_is_missing_is_a_dash_and_no_failure(table, defaults):
    sets = made_plans.make_sets("1 parent", "2 parent")
    html = show(table[table["seeding"] == "parent"], sets, defaults).html
    assert "\N{EN DASH}" in html and "nan" not in html


def test_the_section_says_on_what_terms_it_compares(table, defaults):
    section = show(table, made_plans.make_sets("1 parent"), defaults)
    assert "not subtracted" in section.html and "All is computed" in section.html
    assert "37\u202f855" in section.html


def test_the_terms_are_what_was_measured(table, defaults):
    sets, trees = made_plans.make_sets("1 parent"), made_plans.make_trees("1 parent")
    terms = compare_terms(table, sets, trees, defaults("show_study")).set_index("")
    assert terms.loc["time for each tree"].tolist() == ["1 h", "30 s"]
    assert terms.loc["cores", "paper"] == "8"
    assert terms.loc["cells of the surface", "here"] == f"{len(sets.cells)} of 2 mm"
    assert terms.loc["field of view", "here"] == "90\N{DEGREE SIGN}"


def test_all_runs_are_told_once_each_by_words(table, defaults):
    runs = tell_runs(table)
    assert "name" not in runs and len(runs) == len(table)
    assert set(runs["solves begin at"]) == {"its neighbour", "the start"}


def test_curves_are_of_one_seeding_each(table, defaults):
    sets = made_plans.make_sets("1 parent", "2 parent", "1 start")
    html = show(table, sets, defaults).html
    parent, start = html.split("Each solve begins at")[1:]
    assert "2 parent" in parent and "union" in parent
    assert "1 start" in start.split("<table")[0] and "union" not in start.split("<table")[0]
