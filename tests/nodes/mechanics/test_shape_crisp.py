"""What the shape of a CRISP robot says to later stages and people."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from nodes.errors import BadInput
from nodes.mechanics.parameters import ShapeCrispParameters
from nodes.mechanics.shape_crisp import shape_crisp
from nodes.mechanics.solve_crisp import solve_crisp
from tests.conftest import ROOT
from tests.nodes.mechanics.crisp_reference import CASES, case_robot, column, parameters


def figures(shape):
    return {figure.name: figure.value for figure in shape.figures}


def test_shape_holds_the_solution():
    case = CASES["relaxed2_1"]
    setup, configuration = case_robot(case)
    shape = shape_crisp(setup, configuration, parameters(sample_spacing_mm=5.0))
    assert (shape.status, shape.reason, shape.kind) == ("solved", "", "CRISP")
    assert [rod.name for rod in shape.rods] == ["tool", "snare 1", "snare 2"]
    assert shape.patient_from_tip[:3, 3] == pytest.approx(case["out"]["tip_p"], abs=1e-6)
    for rod, length, tube in zip(shape.rods, case["lengths"], case["tubes"], strict=True):
        assert rod.arc_lengths_mm[0] == 0 and rod.arc_lengths_mm[-1] == length
        assert np.diff(rod.arc_lengths_mm).max() <= 5 + 1e-9
        assert np.diff(rod.arc_lengths_mm).min() > 0
        assert rod.outer_radius_mm == tube["OD"] / 2
        assert np.linalg.norm(rod.tangents, axis=1) == pytest.approx(1, abs=1e-9)
    # Joints come along the tool, and each is where a snare ends.
    along = [joint["snare"] for joint in sorted(case["joints"], key=lambda joint: joint["s"])]
    wanted = {joint["snare"]: joint["p"] for joint in case["out"]["joints"]}
    assert along == [1, 2] and case["joints"][0]["snare"] == 2
    for place, snare in zip(shape.joints_patient_mm, along, strict=True):
        assert place == pytest.approx(wanted[snare], abs=1e-6)
        assert shape.rods[snare].points_patient_mm[-1] == pytest.approx(place, abs=1e-6)


def test_figures_say_what_a_person_judges_by():
    setup, configuration = case_robot(CASES["relaxed1_load_0"])
    shape = shape_crisp(setup, configuration, parameters())
    solution = solve_crisp(setup, configuration, parameters())
    named = figures(shape)
    assert named["stability margin"] == solution.stability_margin
    assert named["bending strain of tool"] == pytest.approx(100 * solution.bending_strains[0])
    assert named["least angle at a joint"] == pytest.approx(90, abs=1e-4)
    snare = shape.rods[1].points_patient_mm
    straight = np.linalg.norm(snare[-1] - snare[0])
    assert named["length to spare"] == pytest.approx(configuration.lengths_mm[1] - straight)
    force = np.linalg.norm(solution.base_wrenches[1, 3:])
    assert named["largest force at a joint"] == pytest.approx(force)
    assert max(named["force out of balance"], named["moment out of balance"]) < 1e-9
    place = shape.loads[0, :3]
    assert shape.loads[0, 3:] == pytest.approx(configuration.loads[0].force_n)
    tool = shape.rods[0]
    here = np.searchsorted(tool.arc_lengths_mm, configuration.loads[0].arc_length_mm)
    assert place == pytest.approx(tool.points_patient_mm[here])


def test_unstable_shape_is_shown_but_not_called_solved():
    # Nothing holds a buckled column from swinging round its axis: its margin is 0.
    setup, configuration = column([0.0, 0.0, -1.2 * np.pi**2 / 4])
    shape = shape_crisp(setup, configuration, parameters(guesses=0))
    assert shape.status == "unstable" and "margin" in shape.reason and len(shape.rods) == 1
    assert figures(shape)["stability margin"] == pytest.approx(0, abs=1e-7)


def test_needles_too_short_are_refused_with_their_numbers():
    setup, configuration = case_robot(CASES["rigid1_0"])
    short = replace(configuration, lengths_mm=np.array([190.0, 1.0]))
    with pytest.raises(BadInput, match="straight"):
        shape_crisp(setup, short, parameters())


def test_moment_on_the_tool_is_said_to_keep_its_axis():
    shape = shape_crisp(*case_robot(CASES["rigid1_load_3"]), parameters())
    assert any("keeps its axis" in notice for notice in shape.origin.notices)
    shape = shape_crisp(*case_robot(CASES["rigid1_load_1"]), parameters())
    assert not any("keeps its axis" in notice for notice in shape.origin.notices)


def test_same_shape_twice_to_the_last_bit():
    robot = case_robot(CASES["sym2_relaxed_same_s"])
    one, two = (shape_crisp(*robot, parameters()) for _ in range(2))
    for a, b in zip(one.rods, two.rods, strict=True):
        assert a.points_patient_mm.tobytes() == b.points_patient_mm.tobytes()


def test_defaults_are_of_the_parameters_type():
    text = (ROOT / "catalog" / "parameters" / "shape_crisp.yml").read_text()
    values = yaml.safe_load(text)
    assert list(values) == list(ShapeCrispParameters.model_fields)
    shape = shape_crisp(*case_robot(CASES["rigid1_0"]), ShapeCrispParameters(**values))
    assert shape.status == "solved"
