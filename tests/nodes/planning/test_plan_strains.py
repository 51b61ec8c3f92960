"""Strains against the general mechanics of another path."""

import numpy as np
import pytest

from nodes.mechanics.robots import CrispConfiguration
from nodes.mechanics.sample_crisp_needles import sample_crisp_needles
from nodes.mechanics.solve_crisp import solve_crisp
from nodes.planning.crisp_collisions import needle_order
from nodes.planning.plan_strains import find_strains
from tests.nodes.mechanics.crisp_reference import CASES, case_robot, case_wrenches, parameters


@pytest.mark.parametrize("name", ["rigid1_0", "relaxed1_1", "rigid2_2", "relaxed2_paper_1"])
def test_strains_are_those_of_the_general_solution(name):
    setup, configuration = case_robot(CASES[name], "tip")
    frames, lengths = configuration.patient_from_entry, configuration.lengths_mm
    wrenches = case_wrenches(CASES[name])
    slow = solve_crisp(setup, CrispConfiguration(frames, lengths), parameters(guesses=0), wrenches)
    borne = [needle.material.recoverable_strain for needle in setup.needles]
    worst = np.max(np.array(slow.bending_strains) / borne)
    points = sample_crisp_needles(setup, frames[None], lengths[None], wrenches[None], 24)
    found = find_strains(setup, points, wrenches[None], needle_order(setup, lengths[None]))
    assert found[0] == pytest.approx(worst, rel=0.02)
