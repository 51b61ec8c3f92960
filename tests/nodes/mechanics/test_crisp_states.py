"""Energy, balance and strain against Castigliano, closed forms and brute force."""

from dataclasses import replace

import numpy as np
import pytest

from nodes.mechanics.crisp_states import measure_imbalance, sample
from nodes.mechanics.solve_crisp import solve_crisp, to_crisp
from tests.nodes.mechanics.crisp_reference import CASES, case_robot, column, parameters


def energy(setup, configuration, wrenches):
    return solve_crisp(setup, configuration, parameters(), wrenches).energy_n_mm


@pytest.mark.parametrize("name", ["relaxed1_load_2", "rigid2_load_2", "mixed2_load_1"])
def test_energy_falls_by_the_place_of_a_growing_force(name):
    setup, configuration = case_robot(CASES[name])
    found = solve_crisp(setup, configuration, parameters())
    load, step = configuration.loads[0], 1e-4
    place = sample(
        to_crisp(setup, configuration), found.base_wrenches, 0, np.array([load.arc_length_mm]), 0.2
    ).points_patient_mm[0]
    for axis in range(3):
        pulled = []
        for sign in (1, -1):
            force = load.force_n + sign * step * np.eye(3)[axis]
            loads = (replace(load, force_n=force), *configuration.loads[1:])
            pulled.append(energy(setup, replace(configuration, loads=loads), found.base_wrenches))
        slope = (pulled[0] - pulled[1]) / (2 * step)
        assert slope == pytest.approx(-place[axis], abs=1e-5)


@pytest.mark.parametrize("name", ["precurved1_1", "relaxed2_paper_load_0", "rigid1_2"])
def test_energy_grows_by_the_force_against_a_moving_entry(name):
    setup, configuration = case_robot(CASES[name])
    found = solve_crisp(setup, configuration, parameters())
    step = 1e-3
    for needle in range(len(setup.needles)):
        for axis in range(3):
            moved = []
            for sign in (1, -1):
                entries = np.array(setup.entry_points_patient_mm)
                entries[needle, axis] += sign * step
                there = replace(setup, entry_points_patient_mm=entries)
                moved.append(energy(there, configuration, found.base_wrenches))
            slope = (moved[0] - moved[1]) / (2 * step)
            assert slope == pytest.approx(-found.base_wrenches[needle, 3 + axis], abs=1e-6)


def test_imbalance_is_what_a_wrong_wrench_leaves():
    setup, configuration = case_robot(CASES["rigid1_0"])
    found = solve_crisp(setup, configuration, parameters())
    assert np.abs(found.imbalance).max() < 1e-9
    wrong = np.array(found.base_wrenches)
    wrong[1] += [0, 0, 0, 0, 0, 1e-3]
    left = measure_imbalance(to_crisp(setup, configuration), wrong, 0.2)
    assert left[5] == pytest.approx(-1e-3, abs=1e-12)
    arm = np.cross(setup.entry_points_patient_mm[1], [0, 0, 1e-3])
    assert left[:3] == pytest.approx(-arm, abs=1e-9)


def test_strain_of_a_cantilever_is_largest_at_its_base():
    setup, configuration = column([0.05, 0.0, 0.0])
    found = solve_crisp(setup, configuration, parameters())
    moment = found.base_wrenches[0, :3]
    bending = to_crisp(setup, configuration).rods.bending[0]
    assert found.bending_strains[0] == pytest.approx(
        np.linalg.norm(moment[:2]) / bending * 1.27 / 2, rel=1e-12
    )
    assert found.bending_strains[0] == pytest.approx(0.05 / 150 * 1.27 / 2, rel=1e-2)


def test_free_precurved_needle_is_a_helix_without_strain():
    case = CASES["free_precurved_helix"]
    setup, configuration = case_robot(case)
    found = solve_crisp(setup, configuration, parameters())
    turn = np.array(case["tubes"][0]["uhat"])
    rate = np.linalg.norm(turn)
    axis, rod = turn / rate, found.rods[0]
    for arc, point in zip(rod.arc_lengths_mm, rod.points_patient_mm, strict=True):
        way = np.array([0, 0, 1.0])  # integral of Rodrigues' formula applied to e_z
        angle = rate * arc
        wanted = way * np.sin(angle) / rate
        wanted = wanted + np.cross(axis, way) * (1 - np.cos(angle)) / rate
        wanted = wanted + axis * (axis @ way) * (arc - np.sin(angle) / rate)
        wanted = np.array(case["base_p"][0]) + np.array(case["base_R"][0]) @ wanted
        assert point == pytest.approx(wanted, abs=1e-8)
    assert found.bending_strains == pytest.approx(0) and found.stability_margin == 1
