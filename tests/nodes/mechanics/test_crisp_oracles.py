"""The two slow solvers of CRISP robots against closed forms and each other."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.mechanics_cases import NEEDLE_NITINOL, random_crisp
from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Needle, PointLoad
from tests.nodes.mechanics import oracle_crisp, oracle_crisp_energy
from tests.nodes.mechanics.oracle_crisp_rods import robot_of


def cantilever(length, force):
    """Return a straight tool along z that a force of the tip pulls, in units of E I / length^2."""
    needle = Needle(NEEDLE_NITINOL, 0.97, 1.27, np.zeros(3))
    setup = CrispSetup((needle,), np.zeros((1, 3)), (), 70.0)
    bending = 50000.0 * np.pi * (1.27**4 - 0.97**4) / 64
    load = PointLoad(length, np.array(force) * bending / length**2, np.zeros(3))
    configuration = CrispConfiguration(np.eye(3)[None], np.array([length]), (load,))
    return robot_of(setup, configuration)


def least_energies(robot, elements=8):
    """Return stationary points with elements halved twice."""
    coarse = oracle_crisp_energy.assemble(robot, elements)
    return [oracle_crisp_energy.refine(robot, coarse, elements, level) for level in range(3)]


def test_cantilever_is_the_elastica():
    robot = cantilever(150.0, [1.0, 0.0, 0.0])
    found = oracle_crisp.solve(robot)
    across, along = found.tip_point[0] / 150, found.tip_point[2] / 150
    assert [along, across] == pytest.approx([0.9436, 0.3017], abs=5e-5)
    assert np.arcsin(found.tip_frame[0, 2]) == pytest.approx(0.4614, abs=5e-5)


@pytest.mark.parametrize("share", [0.5, 0.9, 1.2])
def test_margin_of_a_column_is_eulers(share):
    robot = cantilever(150.0, [0.0, 0.0, -share * np.pi**2 / 4])
    margins = [least.margin for least in least_energies(robot)]
    assert oracle_crisp_energy.extrapolate(*margins) == pytest.approx(1 - share, abs=1e-6)


@pytest.mark.parametrize(
    "joints, loads, precurved",
    [(("relaxed",), 1, True), (("rigid", "relaxed"), 1, False), (("relaxed", "relaxed"), 0, True)],
)
def test_equilibrium_of_wrenches_is_a_stationary_energy(joints, loads, precurved):
    setup, configuration = random_crisp(np.random.default_rng(5), joints, loads, precurved)
    pulls = tuple(replace(load, moment_n_mm=np.zeros(3)) for load in configuration.loads)
    robot = robot_of(setup, replace(configuration, loads=pulls))
    at_rest, least = oracle_crisp.solve(robot), least_energies(robot)
    tip = oracle_crisp_energy.extrapolate(*[level.tip_point for level in least])
    energy = oracle_crisp_energy.extrapolate(*[level.elastic_energy for level in least])
    assert np.abs(least[0].tip_point - at_rest.tip_point).max() > 1e-4  # it is not the same sum
    assert tip == pytest.approx(at_rest.tip_point, abs=1e-4)
    assert energy == pytest.approx(at_rest.elastic_energy, rel=1e-5)


def test_forces_and_moments_balance():
    setup, configuration = random_crisp(np.random.default_rng(3), ("relaxed", "rigid"), 2)
    robot = robot_of(setup, configuration)
    at_rest = oracle_crisp.solve(robot)
    assert np.abs(at_rest.base_wrenches[:, 3:]).max() > 1e-3
    assert oracle_crisp.balance(robot, at_rest) < 1e-9
