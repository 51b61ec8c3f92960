"""The slow solver of concentric tubes against closed forms, so that it may judge the fast one."""

import numpy as np
import pytest

from benchmarks.mechanics_cases import (
    NITINOL,
    random_concentric_configuration,
    random_concentric_robot,
)
from nodes.mechanics.robots import ConcentricTubeConfiguration, ConcentricTubeRobot, Tube
from tests.nodes.mechanics.oracle_concentric_tubes import (
    all_solutions,
    solve,
    stability,
    stiffness,
)


def straight_then_curved(*tubes):
    """Return a robot of (straight, curved, curvature), the innermost first."""
    made = [Tube(NITINOL, 0.5 + 0.5 * n, 0.9 + 0.5 * n, *tube) for n, tube in enumerate(tubes)]
    return ConcentricTubeRobot(tuple(made), np.eye(4))


def configuration(rotations, translations):
    return ConcentricTubeConfiguration(np.array(rotations, float), np.array(translations, float))


def test_one_tube_is_an_arc():
    robot = straight_then_curved((30.0, 50.0, 0.02))
    found = solve(robot, configuration([0.7], [-20.0]))
    away = (1 - np.cos(1.0)) / 0.02
    arc = [away * np.cos(0.7), away * np.sin(0.7), 10.0 + np.sin(1.0) / 0.02]
    assert found.tip_point == pytest.approx(arc, abs=1e-10)


@pytest.mark.parametrize("turn", [0.0, np.pi])
def test_tubes_in_one_plane_share_their_curvature_by_stiffness(turn):
    robot = straight_then_curved((40.0, 30.0, 0.01), (20.0, 30.0, 0.006))
    found = solve(robot, configuration([0.0, turn], [-20.0, 0.0]))
    bending, _ = stiffness(robot)
    bend = (bending[0] * 0.01 + np.cos(turn) * bending[1] * 0.006) / bending.sum()
    arc = [(1 - np.cos(30 * bend)) / bend, 0.0, 20.0 + np.sin(30 * bend) / bend]
    assert found.tip_point == pytest.approx(arc, abs=1e-9)


def test_opposed_tubes_lose_stability_as_the_closed_form_says():
    robot = straight_then_curved((50.0, 60.0, 0.02), (30.0, 45.0, 0.015))
    translations = np.array([-25.0, -10.0])
    bending, _ = stiffness(robot)
    begin, end = 25.0, 65.0  # where both are curved
    upstream = (begin - translations) @ bending[::-1] / bending.sum()
    wave = np.sqrt(1.33 * 0.02 * 0.015)
    closed = np.cos(wave * (end - begin)) - wave * upstream * np.sin(wave * (end - begin))
    assert stability(robot, translations, np.array([0.0, np.pi])) == pytest.approx(closed, abs=1e-7)


@pytest.mark.parametrize("length, count", [(0.9, 1), (1.1, 3)])
def test_equal_opposed_tubes_have_one_solution_up_to_the_critical_length(length, count):
    curved = length * np.pi / 2 / np.sqrt(1.33 * 0.02 * 0.02)
    robot = straight_then_curved((0.0, curved, 0.02), (0.0, curved, 0.02))
    assert len(all_solutions(robot, configuration([0.0, np.pi], [0.0, 0.0]), 6)) == count


@pytest.mark.parametrize("count", [2, 3, 4])
def test_torques_add_up_to_nothing_everywhere(count):
    chance = np.random.default_rng(count)
    robot = random_concentric_robot(chance, count)
    found = solve(robot, random_concentric_configuration(chance, robot))
    arcs = np.linspace(0.0, found.dense[-1].t_max, 9)
    torques = found.twists(arcs) * stiffness(robot)[1]
    assert np.abs(torques).max() > 1e-3
    assert np.abs(torques.sum(1)).max() < 1e-9
