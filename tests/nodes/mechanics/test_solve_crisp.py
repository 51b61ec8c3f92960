"""Equilibria against reference solutions, the elastica, Euler's column, and each other."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipeinc, ellipkinc

from nodes.errors import BadInput
from nodes.mechanics.crisp_states import sample
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.solve_crisp import find_crisp_equilibria, solve_crisp, step_turn, to_crisp
from tests.nodes.mechanics.crisp_reference import (
    CASES,
    case_robot,
    case_wrenches,
    column,
    parameters,
)
from tests.nodes.mechanics.made_crisp_edges import PARAMETERS, edges_from

MIRRORED = "sym2_relaxed_same_s"  # two mirror images of equal energy: either is right


@pytest.mark.parametrize("name", CASES)
def test_reference_solutions_are_found_without_a_guess(name):
    case = CASES[name]
    setup, configuration = case_robot(case)
    found = find_crisp_equilibria(setup, configuration, parameters())
    stable = [solution for solution in found if solution.status == "solved"]
    wanted = case_wrenches(case)
    ways = [np.abs(solution.base_wrenches - wanted).max() for solution in stable]
    best = stable[int(np.argmin(ways))]
    assert best is stable[0] or name == MIRRORED
    assert min(ways) <= 1e-6 * max(np.abs(wanted).max(), 1e-9)
    assert best.patient_from_camera[:3, 3] == pytest.approx(case["out"]["tip_p"], abs=1e-6)
    assert best.patient_from_camera[:3, :3] == pytest.approx(
        np.array(case["out"]["tip_R"]), abs=1e-8
    )
    crisp = to_crisp(setup, configuration)
    for rod, backbone in enumerate(case["out"]["backbone"]):
        arcs, reach = np.array(backbone["s"]), step_turn(crisp, 1e-9)
        points = sample(crisp, best.base_wrenches, rod, arcs, reach).points_patient_mm
        assert np.abs(points - backbone["p"]).max() < 1e-6
    assert np.abs(best.imbalance).max() < 1e-9


@pytest.mark.parametrize("name", CASES)
def test_margin_energy_and_joints_are_the_references(name):
    case = CASES[name]
    setup, configuration = case_robot(case)
    found = solve_crisp(setup, configuration, parameters(), case_wrenches(case))
    # The reference cuts rods into elements, and takes its energy from a coarse quadrature.
    moments = any(np.any(load["T"]) for load in case["loads"])
    accuracy = 6e-3 if moments else 4e-3
    assert found.stability_margin == pytest.approx(
        case["check"]["min_reduced_hessian_eig"], abs=accuracy
    )
    assert found.energy_n_mm == pytest.approx(case["check"]["energy"], rel=1e-2, abs=1e-9)
    joints = sorted(case["out"]["joints"], key=lambda joint: np.linalg.norm(joint["p"]))
    places = found.patient_from_joints[:, :3, 3]
    places = places[np.argsort(np.linalg.norm(places, axis=1))]
    assert places.ravel() == pytest.approx(np.ravel([j["p"] for j in joints]), abs=1e-6)
    for wrench in found.joint_wrenches:
        tips = [[*joint["m_snare_tip"], *joint["n_snare_tip"]] for joint in joints]
        assert np.abs(np.array(tips) - wrench).max(axis=1).min() < 1e-7


def exact_elastica(load):
    """Return x / L, y / L and angle at the tip of a cantilever, F L^2 / E I = load, by elliptic
    integrals [Bisshopp1945]."""

    def integrals(angle):
        modulus = (1 + np.sin(angle)) / 2
        begin = np.arcsin(1 / np.sqrt(2 * modulus))
        first = ellipkinc(np.pi / 2, modulus) - ellipkinc(begin, modulus)
        second = ellipeinc(np.pi / 2, modulus) - ellipeinc(begin, modulus)
        return first, second

    angle = brentq(lambda a: integrals(a)[0] - np.sqrt(load), 1e-9, np.pi / 2 - 1e-9, xtol=1e-15)
    along = np.sqrt(2 * np.sin(angle) / load)
    return along, 1 - 2 * integrals(angle)[1] / np.sqrt(load), angle


def test_exact_elastica_is_the_published_one():
    assert exact_elastica(1.0) == pytest.approx([0.9436, 0.3017, 0.4614], abs=5e-5)


@pytest.mark.parametrize("load", [0.1, 1.0, 5.0, 20.0])
def test_cantilever_is_the_elastica(load):
    found = solve_crisp(*column([load, 0.0, 0.0]), parameters())
    tip = found.patient_from_camera
    angle = np.arctan2(tip[0, 2], tip[2, 2])
    along, across, turned = exact_elastica(load)
    assert tip[[2, 0], 3] / 150 == pytest.approx([along, across], abs=1e-9)
    assert angle == pytest.approx(turned, abs=1e-9)


@pytest.mark.parametrize("share", [-1.0, 0.5, 0.9, 0.999, 1.001, 1.5, 8.0])
def test_margin_of_a_column_is_eulers(share):
    setup, configuration = column([0.0, 0.0, -share * np.pi**2 / 4])
    straight = np.zeros((1, 6))
    straight[0, 3:] = configuration.loads[0].force_n
    found = find_crisp_equilibria(setup, configuration, parameters(guesses=0))
    upright = found[-1]
    assert upright.base_wrenches == pytest.approx(straight, abs=1e-12)
    # Buckling load over load; a column that is pulled is only stiffer, its modes crowd at 1.
    wanted = 1 - share if share > 0 else 1.0
    margin = upright.stability_margin
    assert 1 - margin == pytest.approx(1 - wanted, rel=1e-7, abs=1e-9)
    assert upright.status == ("solved" if share < 1 else "unstable")
    # What it buckles to is found from the way in which it gives, without any random start.
    assert len(found) == 1 if share < 1 else found[0].energy_n_mm < upright.energy_n_mm


@pytest.mark.parametrize("push, share", [(1e-3, 1.2), (1e-3, 3.0), (1e-5, 1.5), (1e-5, 3.0)])
def test_column_buckles_to_the_side_of_the_least_push(push, share):
    setup, configuration = column([push, 0.0, -share * np.pi**2 / 4])
    found = solve_crisp(setup, configuration, parameters(guesses=0))
    assert found.status == "solved" and found.patient_from_camera[0, 3] > 50
    # The swing round the axis alone costs little: the margin is as small as the push.
    assert 0 < found.stability_margin < push


def test_buckled_column_rests_at_less_energy():
    setup, configuration = column([0.1, 0.0, -1.5 * np.pi**2 / 4])
    found = find_crisp_equilibria(setup, configuration, parameters())
    energies = [solution.energy_n_mm for solution in found]
    assert len(found) == 3 and energies == sorted(energies)
    sides = [np.sign(solution.patient_from_camera[0, 3]) for solution in found[:2]]
    assert sides == [1, -1]  # with the small push, and against it
    # Against it is a hollow in the plane alone: the column swings round its axis to the other side.
    assert [solution.status for solution in found] == ["solved", "unstable", "unstable"]
    assert -0.05 < found[1].stability_margin < 0
    assert solve_crisp(setup, configuration, parameters()).energy_n_mm == energies[0]


def test_mirror_images_are_told_apart_from_the_saddle_between():
    setup, configuration = case_robot(CASES[MIRRORED])
    found = find_crisp_equilibria(setup, configuration, parameters())
    assert [solution.status for solution in found] == [
        "solved",
        "solved",
        *["unstable"] * (len(found) - 2),
    ]
    assert len(found) > 2 and found[0].energy_n_mm == pytest.approx(found[1].energy_n_mm, rel=1e-9)
    assert found[2].energy_n_mm > found[1].energy_n_mm + 0.1
    assert np.abs(found[0].patient_from_camera - found[1].patient_from_camera).max() > 1


def test_warm_start_follows_its_branch_and_returns_the_same():
    setup, configuration = case_robot(CASES["relaxed2_paper_load_0"])
    first = solve_crisp(setup, configuration, parameters())
    lengths = configuration.lengths_mm + np.array([0.5, -0.3, 0.2])
    nudged = replace(configuration, lengths_mm=lengths)
    near = solve_crisp(setup, nudged, parameters(), first.base_wrenches)
    cold = solve_crisp(setup, nudged, parameters())
    assert near.status == "solved" and near.iterations < cold.iterations
    assert near.base_wrenches == pytest.approx(cold.base_wrenches, abs=1e-8)


def test_a_seed_that_leads_nowhere_gives_no_other_branch():
    setup, configuration = case_robot(CASES["rigid2_load_0"])
    wild = 1e3 * np.random.default_rng(1).normal(size=(3, 6))
    found = solve_crisp(setup, configuration, parameters(), wild)
    assert found.status == "not converged" and "branch" in found.reason and not found.rods
    assert found.base_wrenches == pytest.approx(wild)


def test_a_seed_on_an_unstable_branch_stays_there():
    setup, configuration = case_robot(CASES[MIRRORED])
    saddle = find_crisp_equilibria(setup, configuration, parameters())[2]
    nudged = replace(configuration, lengths_mm=configuration.lengths_mm + 0.1)
    found = solve_crisp(setup, nudged, parameters(), saddle.base_wrenches)
    assert found.status == "unstable" and "margin" in found.reason
    assert found.stability_margin == pytest.approx(saddle.stability_margin, rel=0.1)


def test_needles_too_short_to_meet_have_no_solution():
    setup, configuration = case_robot(CASES["rigid1_0"])
    short = replace(configuration, lengths_mm=np.array([190.0, 1.0]))
    found = solve_crisp(setup, short, parameters())
    assert found.status == "no solution" and "no shorter" in found.reason and not found.rods


def test_needles_that_just_cannot_meet_do_not_converge():
    # Long enough for straight ways, but the clamped tangents bend them away from there.
    setup, configuration = case_robot(CASES["rigid1_0"])
    ways = setup.entry_points_patient_mm[1] - setup.entry_points_patient_mm[0]
    least = np.linalg.norm(ways) - CASES["rigid1_0"]["joints"][0]["s"]
    tight = replace(configuration, lengths_mm=np.array([190.0, max(least, 0.0) + 1e-6]))
    found = solve_crisp(setup, tight, parameters(guesses=1))
    assert found.status == "not converged" and "mm are left" in found.reason


@pytest.mark.parametrize("name", ["rigid1_2", "relaxed1_1", "rigid2_2", "relaxed2_1"])
def test_straight_unloaded_needles_are_those_of_the_fast_path(name):
    setup, configuration = case_robot(CASES[name])
    fine = PARAMETERS.model_copy(update={"tolerance_mm": 1e-10, "integration_error_mm": 1e-10})
    frames, lengths = configuration.patient_from_entry, configuration.lengths_mm
    edges = edges_from(frames, lengths, case_wrenches(CASES[name]), count=2, steps=3, step=0.5)
    tracks = follow_crisp_edges(setup, edges, fine)
    for edge in range(2):
        there = replace(
            configuration,
            patient_from_entry=edges.ends[edge],
            lengths_mm=edges.end_lengths_mm[edge],
        )
        found = solve_crisp(setup, there, parameters(), tracks.wrenches[edge, 3])
        camera = tracks.patient_from_camera[edge, 3]
        assert found.status == "solved"
        assert found.patient_from_camera == pytest.approx(camera, abs=1e-8)


@pytest.mark.parametrize("apart", [3e-14, 1e-6, 1e-3, 0.05])
def test_margin_does_not_change_where_a_load_comes_near_a_joint(apart):
    setup, configuration = case_robot(CASES["relaxed1_load_0"])
    joint = CASES["relaxed1_load_0"]["joints"][0]["s"]

    def margin(place):
        load = replace(configuration.loads[0], arc_length_mm=place)
        loaded = replace(configuration, loads=(load,))
        return solve_crisp(setup, loaded, parameters(guesses=0)).stability_margin

    # It changes by 1.3e-3 / mm; what is left is rounding of so short a piece's stiffness.
    assert margin(joint + apart) == pytest.approx(margin(joint), abs=2e-3 * apart + 1e-4)


@pytest.mark.parametrize("seed", [np.zeros((1, 6)), np.full((2, 6), np.nan)])
def test_a_seed_that_does_not_fit_is_refused(seed):
    setup, configuration = case_robot(CASES["relaxed1_1"])
    with pytest.raises(BadInput, match="a seed of shape"):
        solve_crisp(setup, configuration, parameters(), seed)
