"""What pages say of a robot is what was given."""

import numpy as np

from nodes.mechanics.describe_robots import describe_crisp, tell_overbent
from nodes.mechanics.robots import Material
from tests.nodes.mechanics.crisp_reference import CASES, case_robot


def test_lengths_grasps_and_loads_of_a_crisp_robot_are_told():
    case = CASES["mixed2_load_1"]
    setup, configuration = case_robot(case)
    given = {one.name: one for one in describe_crisp(setup, configuration)}
    assert given["length of tool"].value == case["lengths"][0]
    assert given["length of snare 2"].value == case["lengths"][2]
    kinds = {f"snare {joint['snare']}": joint["type"] for joint in case["joints"]}
    for joint in case["joints"]:
        told = given[f"grasp of snare {joint['snare']}"]
        assert abs(told.value - joint["s"]) < 1e-9
        assert told.meaning.startswith(kinds[f"snare {joint['snare']}"])
    size = np.linalg.norm(case["loads"][0]["F"])
    assert abs(given["load 1"].value - size) < 1e-12
    assert f"at {case['loads'][0]['s']:g} mm" in given["load 1"].meaning


def test_pre_curvature_is_told_only_where_there_is_one():
    for name, bent in (("precurved1_1", True), ("relaxed1_1", False)):
        figures = describe_crisp(*case_robot(CASES[name]))
        assert any("pre-curved" in one.meaning for one in figures) == bent


def test_an_overbent_tube_is_told_with_both_strains():
    told = tell_overbent("tool", 0.093, Material("nitinol", 5e4, 0.3, 0.08))
    assert "tool is strained by 9.3 %" in told and "8 %" in told
