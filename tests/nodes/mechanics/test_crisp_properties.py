"""CRISP robots against the two slow solvers, and what holds for all of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.mechanics_cases import offset_configuration, random_crisp, random_pose
from benchmarks.mechanics_edges import edges_between, ends_of, random_targets
from nodes.mechanics.crisp_edges import BEYOND, SOLVED
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.parameters import FollowCrispEdgesParameters, ShapeCrispParameters
from nodes.mechanics.solve_crisp import solve_crisp
from tests.nodes.mechanics import oracle_crisp, oracle_crisp_energy
from tests.nodes.mechanics.oracle_crisp_rods import robot_of

SEEDS = st.integers(0, 2**32 - 1)
GRASPS = st.lists(st.sampled_from(["rigid", "relaxed"]), max_size=2).map(tuple)
MIRROR = np.diag([1.0, -1.0, 1.0])
SHAPE = ShapeCrispParameters(
    tolerance_mm=1e-9, sample_spacing_mm=50.0, guesses=0, seed=0, same_equilibrium=1e-5,
    margin_accuracy=1e-6,
)  # fmt: skip
FOLLOW = FollowCrispEdgesParameters(
    tolerance_mm=1e-7, integration_error_mm=1e-8, largest_bend_rad=0.5, iterations=20,
    steps_between_checks=5, refinements=2,
)  # fmt: skip

CASES = [
    ((), 2, True),
    (("relaxed",), 0, False),
    (("rigid",), 1, False),
    (("relaxed",), 2, True),
    (("rigid", "relaxed"), 0, False),
    (("relaxed", "relaxed"), 2, True),
    (("rigid", "rigid"), 1, True),
    (("relaxed",) * 3, 1, False),
]


def random_case(seed, joints, loads=0, precurved=False):
    """Return a setup, a configuration and what is found of it."""
    setup, configuration = random_crisp(np.random.default_rng(seed), joints, loads, precurved)
    return setup, configuration, solve_crisp(setup, configuration, SHAPE)


def moved(setup, configuration, move):
    """Return all of it, with its loads, after a rigid motion."""
    turn = move[:3, :3]
    entries = setup.entry_points_patient_mm @ turn.T + move[:3, 3]
    loads = tuple(
        replace(load, force_n=turn @ load.force_n, moment_n_mm=turn @ load.moment_n_mm)
        for load in configuration.loads
    )
    frames = turn @ configuration.patient_from_entry
    return (
        replace(setup, entry_points_patient_mm=entries),
        replace(configuration, patient_from_entry=frames, loads=loads),
    )


def mirrored(setup, configuration):
    """Return the mirror image across the plane y = 0; the body's own y is turned round, too."""
    needles = tuple(
        replace(needle, precurvature_per_mm=needle.precurvature_per_mm * [-1, 1, -1])
        for needle in setup.needles
    )
    loads = tuple(
        replace(load, force_n=MIRROR @ load.force_n, moment_n_mm=-MIRROR @ load.moment_n_mm)
        for load in configuration.loads
    )
    frames = MIRROR @ configuration.patient_from_entry @ MIRROR
    entries = setup.entry_points_patient_mm @ MIRROR
    return (
        replace(setup, needles=needles, entry_points_patient_mm=entries),
        replace(configuration, patient_from_entry=frames, loads=loads),
    )


@pytest.mark.parametrize("joints, loads, precurved", CASES)
def test_shape_is_what_integrating_all_wrenches_finds(joints, loads, precurved):
    setup, configuration, found = random_case(1, joints, loads, precurved)
    robot = robot_of(setup, configuration)
    slow = oracle_crisp.solve(robot)
    assert found.status == "solved"
    assert found.patient_from_camera[:3, 3] == pytest.approx(slow.tip_point, abs=1e-6)
    assert found.patient_from_camera[:3, :3] == pytest.approx(slow.tip_frame, abs=1e-8)
    assert np.abs((found.base_wrenches - slow.base_wrenches) / robot.scale).max() < 1e-7
    for number, rod in enumerate(found.rods):
        points = slow.points(number, rod.arc_lengths_mm)
        assert np.abs(rod.points_patient_mm - points).max() < 1e-6


@pytest.mark.parametrize("joints", [("relaxed",), ("rigid", "relaxed")])
def test_margin_and_energy_are_those_of_elements(joints):
    setup, configuration, found = random_case(2, joints, 1, True)
    pulls = tuple(replace(load, moment_n_mm=np.zeros(3)) for load in configuration.loads)
    configuration = replace(configuration, loads=pulls)
    found = solve_crisp(setup, configuration, SHAPE)
    robot = robot_of(setup, configuration)
    coarse = oracle_crisp_energy.assemble(robot, 8)
    levels = [oracle_crisp_energy.refine(robot, coarse, 8, level) for level in range(3)]
    margin = oracle_crisp_energy.extrapolate(*[level.margin for level in levels])
    assert found.stability_margin == pytest.approx(margin, abs=2e-5)


@settings(max_examples=12)
@given(SEEDS, GRASPS, st.booleans())
def test_robot_moves_with_its_entry_points(seed, joints, general):
    setup, configuration, found = random_case(seed, joints, int(general), general)
    move = random_pose(np.random.default_rng(seed))
    after = solve_crisp(*moved(setup, configuration, move), SHAPE)
    assert after.status == found.status == "solved"
    assert after.patient_from_camera == pytest.approx(move @ found.patient_from_camera, abs=1e-6)
    assert after.stability_margin == pytest.approx(found.stability_margin, abs=1e-5)


@settings(max_examples=12)
@given(SEEDS, st.lists(st.just("relaxed"), max_size=2).map(tuple), st.booleans())
def test_mirror_image_bends_the_other_way(seed, joints, general):
    setup, configuration, found = random_case(seed, joints, int(general), general)
    after = solve_crisp(*mirrored(setup, configuration), SHAPE)
    assert after.patient_from_camera[:3, 3] == pytest.approx(
        MIRROR @ found.patient_from_camera[:3, 3], abs=1e-6
    )
    assert after.energy_n_mm == pytest.approx(found.energy_n_mm, abs=1e-6)


@settings(max_examples=12)
@given(SEEDS, GRASPS, st.integers(0, 2))
def test_forces_and_moments_balance_at_the_entry_points(seed, joints, loads):
    setup, configuration, found = random_case(seed, joints, loads, True)
    robot = robot_of(setup, configuration)
    slow = oracle_crisp.polish(robot, found.base_wrenches)
    given_wrenches = replace(slow, base_wrenches=found.base_wrenches)
    assert oracle_crisp.balance(robot, given_wrenches) < 1e-7
    assert np.abs(found.imbalance).max() < 1e-9


def there_and_back(setup, first, seed, count=6):
    """Return edges to random targets and the same backwards, each from what the other ended in."""
    targets = random_targets(np.random.default_rng(seed), len(first.lengths_mm), count)
    there = edges_between(first, 0 * targets, targets)
    at_ends = follow_crisp_edges(setup, there, FOLLOW)
    back = replace(
        edges_between(first, targets, 0 * targets), start_wrenches=ends_of(there, at_ends)
    )
    return targets, there, at_ends, back, follow_crisp_edges(setup, back, FOLLOW)


@pytest.mark.parametrize("joints", [("relaxed",), ("rigid",), ("rigid", "relaxed")])
def test_way_back_ends_where_it_began(joints):
    setup, first = random_crisp(np.random.default_rng(4), joints)
    _, _, at_ends, back, home = there_and_back(setup, first, 4)
    assert (at_ends.status[:, 0] == SOLVED).all() and not np.isnan(ends_of(back, home)).any()
    # Along a needle that is hardly bent 1e-7 mm takes much force, so wrenches are known less well.
    apart = (ends_of(back, home) - at_ends.wrenches[:, 0]) / robot_of(setup, first).scale
    assert np.abs(apart).max() < 1e-4
    cameras = home.patient_from_camera[np.arange(len(back.steps)), back.steps]
    assert cameras == pytest.approx(at_ends.patient_from_camera[:, 0], abs=1e-6)


@pytest.mark.parametrize("joints", [("relaxed",), ("rigid", "relaxed")])
def test_edges_end_where_integrating_all_wrenches_does(joints):
    setup, first = random_crisp(np.random.default_rng(6), joints)
    targets, there, at_ends, *_ = there_and_back(setup, first, 6, 2)
    for edge, target in enumerate(targets):
        robot = robot_of(setup, offset_configuration(first, target))
        slow = oracle_crisp.polish(robot, ends_of(there, at_ends)[edge])
        camera = at_ends.patient_from_camera[edge, there.steps[edge]]
        assert camera[:3, 3] == pytest.approx(slow.tip_point, abs=1e-6)
        assert camera[:3, :3] == pytest.approx(slow.tip_frame, abs=1e-8)


@pytest.mark.parametrize("joints", [("relaxed",), ("rigid", "relaxed"), ("relaxed",) * 3])
def test_start_from_no_wrench_is_as_exact_as_from_its_own(joints):
    setup, first = random_crisp(np.random.default_rng(4), joints)
    nowhere = np.zeros((1, len(first.lengths_mm), 4))
    start = edges_between(first, nowhere, nowhere, 0)
    found = follow_crisp_edges(setup, start, FOLLOW)
    slow = oracle_crisp.polish(robot_of(setup, first), found.wrenches[0, 0])
    assert found.patient_from_camera[0, 0, :3, 3] == pytest.approx(slow.tip_point, abs=1e-6)


def test_beyond_the_end_of_an_edge_there_is_nothing():
    setup, first = random_crisp(np.random.default_rng(8), ("relaxed",))
    _, there, at_ends, *_ = there_and_back(setup, first, 8)
    later = np.arange(at_ends.status.shape[1]) > there.steps[:, None]
    assert (at_ends.status[later] == BEYOND).all()
    assert np.isnan(at_ends.wrenches[later]).all()
