"""Points along needles against published backbones and the camera's place."""

import numpy as np
import pytest

from nodes.mechanics.sample_crisp_needles import sample_crisp_needles
from tests.nodes.mechanics.crisp_reference import CASES, case_robot, case_wrenches


def sample(name, pieces):
    case = CASES[name]
    setup, configuration = case_robot(case)
    lengths = configuration.lengths_mm[None]
    frames = configuration.patient_from_entry[None]
    return sample_crisp_needles(setup, frames, lengths, case_wrenches(case)[None], pieces)


@pytest.mark.parametrize("name", ["rigid1_2", "relaxed2_1", "sym2_relaxed_same_s"])
def test_needles_run_from_entry_points_through_joints_to_the_tip(name):
    points, case = sample(name, 20), CASES[name]
    joints = sorted(case["joints"], key=lambda joint: joint["s"])
    places = {joint["snare"]: joint["p"] for joint in case["out"]["joints"]}
    tool = points.tool_patient_mm[0]
    assert np.abs(tool[0] - case["base_p"][0]).max() < 1e-9
    assert np.abs(tool[-1] - case["out"]["tip_p"]).max() < 1e-6
    for number, joint in enumerate(joints):
        snare = points.snares_patient_mm[0, number]
        assert np.abs(snare[0] - case["base_p"][joint["snare"]]).max() < 1e-9
        assert np.abs(snare[-1] - places[joint["snare"]]).max() < 1e-6
        assert np.abs(tool[20 * (number + 1)] - places[joint["snare"]]).max() < 1e-6


def test_points_of_snares_lie_on_the_published_backbone():
    case, joint = CASES["relaxed1_3"], CASES["relaxed1_3"]["joints"][0]
    backbone, length = case["out"]["backbone"][joint["snare"]], case["lengths"][joint["snare"]]
    pieces = 12
    points = sample("relaxed1_3", pieces).snares_patient_mm[0, 0]
    places, arcs = np.array(backbone["p"]), np.array(backbone["s"])
    for number, point in enumerate(points):
        arc = length * number / pieces
        # A chord of 10 mm leaves a curve of radius R by less than 100 / 8 R, and R is over 50 mm.
        near = np.array([np.interp(arc, arcs, places[:, axis]) for axis in range(3)])
        assert np.linalg.norm(point - near) < 0.25


def test_more_pieces_pass_through_the_same_points():
    coarse, fine = sample("rigid2_0", 10), sample("rigid2_0", 20)
    apart = coarse.snares_patient_mm[0] - fine.snares_patient_mm[0, :, ::2]
    assert np.abs(apart).max() < 1e-7
