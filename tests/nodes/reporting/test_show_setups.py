import numpy as np
import pandas as pd
import pytest

from nodes.planning.artefacts import CrispTrees
from nodes.reporting.show_setups import show_setups, tell_candidates
from tests.nodes.reporting import made_plans
from tests.nodes.reporting.test_show_sites import scene_of

CANDIDATES = pd.DataFrame({"number": [3, 1, 2], "share_seen": [0.4, 0.3, 0.2]})


@pytest.fixture(scope="module")
def section(balls, defaults):
    parameters = defaults("show_setups", rows=2, shown=("bone", "left_lung"))
    return show_setups(made_plans.make_trees("front", "back"), CANDIDATES, balls, parameters)


def test_each_set_up_is_a_choice_with_a_robot_of_its_own(section):
    scene = scene_of(section)
    assert [choice["name"] for choice in scene["choices"]] == ["front", "back"]
    tools = [item["choice"] for item in scene["objects"] if item["name"] == "camera tube"]
    assert tools == [0, 1]


def test_only_the_wanted_anatomy_is_shown(section):
    names = {item["name"] for item in scene_of(section)["objects"]}
    assert {"bone", "left lung"} <= names and "body" not in names


def test_needles_are_told_with_entries_grasps_and_camera(section):
    assert "[-38.0, 0.0, 0.0]" in section.html
    assert "relaxed, 10 mm from the tip" in section.html and "1.02 / 0.84" in section.html
    assert "the camera: 90\N{DEGREE SIGN} field of view" in section.html


def test_the_table_says_how_many_candidates_it_leaves_out(section):
    assert "The best 2 of 3 candidates" in section.html
    assert "40.0" in section.html and "20.0" not in section.html


def test_no_set_up_is_no_picture(balls, defaults):
    none = CrispTrees((), made_plans.ORIGIN)
    section = show_setups(none, CANDIDATES, balls, defaults("show_setups"))
    assert section.scripts == () and "viewer3d" not in section.html


def test_set_ups_that_are_left_out_are_nowhere(balls, defaults):
    trees = made_plans.make_trees("front, from parent", "front, from zero")
    parameters = defaults("show_setups", left_out=("from zero",))
    section = show_setups(trees, CANDIDATES, balls, parameters)
    assert len(scene_of(section)["choices"]) == 1 and "zero" not in section.html


def test_candidates_are_told_with_the_share_of_the_last_round_that_they_reached():
    told = tell_candidates(
        pd.DataFrame({
            "name": ["setup 1", "entries 4, 5"], "chosen": [True, False], "rank": [1, 2],
            "needles": [2, 2], "entries": ["3, 4", "4, 5"], "share_unbent": [0.1, 0.2],
            "share_round_1": [0.3, 0.25], "share_round_2": [0.5, np.nan], "nodes": [750, 375],
        })
    )  # fmt: skip
    assert told["chosen as"].tolist()[0] == "setup 1" and pd.isna(told["chosen as"].tolist()[1])
    assert told["share_seen in its last round_percent"].tolist() == [50, 25]
    assert list(told)[1:3] == ["entries", "share_seen by unbent starts_percent"]
