"""How solves end, one at a time and many at once."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.mechanics_cases import offset_configuration, random_crisp
from benchmarks.mechanics_edges import random_targets, solve_near
from nodes.kernels.crisp_general_batch import solve_many
from nodes.kernels.crisp_general_cold import solve_from_rest
from nodes.kernels.crisp_general_problem import pack
from nodes.kernels.crisp_general_solve import (
    NO_SOLUTION,
    NOT_CONVERGED,
    SOLVED,
    UNSTABLE,
    new_newton,
    solve_wrenches,
)
from nodes.kernels.crisp_general_units import is_out_of_reach
from nodes.kernels.crisp_stability import EXACT, QUICK, count_below, new_sturm
from nodes.mechanics.solve_crisp import find_crisp_equilibria, solve_crisp, to_crisp
from tests.nodes.mechanics.crisp_reference import CASES, case_robot, case_wrenches, parameters

NO_SEEDS = np.empty((0, 3, 6))


def packed(name):
    return pack(to_crisp(*case_robot(CASES[name])))


@pytest.mark.parametrize("name", ["rigid1_load_1", "relaxed2_paper_load_0", "precurved1_1"])
def test_random_neighbours_are_all_solved_from_the_middle(name):
    crisp, count = to_crisp(*case_robot(CASES[name])), 60
    chance = np.random.default_rng(0)
    n = len(crisp.lengths)
    turns = Rotation.from_rotvec(np.radians(0.6) * chance.normal(size=(count * n, 3)))
    rotations = np.ascontiguousarray(turns.as_matrix().reshape(count, n, 3, 3) @ crisp.rotations)
    lengths = crisp.lengths + chance.uniform(-1, 1, (count, n))
    arcs = np.repeat(crisp.grasps.arc[None], count, 0)
    wrenches, found = np.repeat(case_wrenches(CASES[name])[None], count, 0), np.empty((count, 4))
    solve_many(pack(crisp), rotations, lengths, arcs, wrenches, 1e-8, True, found)
    assert (found[:, 0] == SOLVED).all() and found[:, 1].max() < 1e-8
    assert found[:, 2].mean() < 3  # chords spare derivatives
    for row in (0, count - 1):  # one by one from nothing it is the same
        one = pack(crisp._replace(rotations=rotations[row], lengths=lengths[row]))
        alone = np.empty((n, 6))
        status, *_ = solve_from_rest(one, alone, NO_SEEDS[:, :n], 1e-8, new_newton(one))
        assert status == SOLVED
        assert wrenches[row] == pytest.approx(alone, abs=1e-7 * np.abs(alone).max())


def test_a_robot_that_gives_way_easily_keeps_its_branch():
    # Its guess is 3 mm off, and the way to the solution leads through larger residuals.
    setup, first = random_crisp(np.random.default_rng(2), ("relaxed",) * 2)
    parent = solve_crisp(setup, first, parameters(guesses=0)).base_wrenches
    offsets = random_targets(np.random.default_rng(3), 3, 100, (1.0, 1.0))
    far = [offset_configuration(first, offset) for offset in offsets]
    found, wrenches = solve_near(setup, far, parent)
    assert (found[:, 0] == SOLVED).all()
    for row in np.argsort(-found[:, 2])[:3]:  # the hardest, in small steps
        slow = parent
        for share in np.linspace(0, 1, 17)[1:]:
            near = offset_configuration(first, share * offsets[row])
            slow = solve_crisp(setup, near, parameters(), slow).base_wrenches
        assert wrenches[row] == pytest.approx(slow, abs=1e-5 * np.abs(slow).max())


def test_batch_tells_unstable_from_solved():
    setup, configuration = case_robot(CASES["relaxed1_1"])
    found = find_crisp_equilibria(setup, configuration, parameters())
    crisp = to_crisp(setup, configuration)
    wrenches = np.array([one.base_wrenches for one in found])
    count = len(found)
    assert count > 1 and found[0].stability_margin > 0 > found[1].stability_margin

    def statuses(check):
        told = np.empty((count, 4))
        solve_many(
            pack(crisp),
            np.repeat(crisp.rotations[None], count, 0),
            np.repeat(crisp.lengths[None], count, 0),
            np.repeat(crisp.grasps.arc[None], count, 0),
            wrenches.copy(), 1e-8, check, told,
        )  # fmt: skip
        return list(told[:, 0])

    assert statuses(False) == [SOLVED] * count
    assert statuses(True) == [SOLVED] + [UNSTABLE] * (count - 1)


@pytest.mark.parametrize("seed", range(8))
def test_wild_guesses_end_soon_and_are_not_called_solved_if_they_are_not(seed):
    crisp = packed("rigid2_load_0")
    scale = crisp.bases[0, 12] ** np.array([-1.0] * 3 + [-2.0] * 3) / crisp.soft[0, 0]
    wrench = 20 * scale * np.random.default_rng(seed).normal(size=(3, 6))
    newton = new_newton(crisp)
    status, size, full, short = solve_wrenches(crisp, wrench, 1e-8, newton)
    assert status in (SOLVED, NOT_CONVERGED) and (size < 1e-8) == (status == SOLVED)
    assert full <= 30 and short <= 150


def test_nonsense_is_not_converged():
    crisp = packed("rigid2_0")
    for nonsense in (np.nan, np.inf, 1e200):
        status, *_ = solve_wrenches(crisp, np.full((3, 6), nonsense), 1e-8, new_newton(crisp))
        assert status == NOT_CONVERGED


def test_reach_is_that_of_straight_needles():
    setup, configuration = case_robot(CASES["rigid2_0"])
    crisp = to_crisp(setup, configuration)
    apart = np.linalg.norm(crisp.rods.entry[1] - crisp.rods.entry[0])
    arc = crisp.grasps.arc[list(crisp.grasps.snare).index(1)]
    for margin, beyond in ((1e-6, False), (-1e-6, True)):
        lengths = np.array(crisp.lengths)
        lengths[1] = apart - arc + margin
        short = pack(crisp._replace(lengths=lengths))
        assert is_out_of_reach(short) == beyond
        if beyond:
            status, *_ = solve_wrenches(short, np.zeros((3, 6)), 1e-8, new_newton(short))
            assert status == NO_SOLUTION


def test_quick_and_exact_counts_agree():
    for name, case in CASES.items():
        crisp, wrench = packed(name), case_wrenches(case)
        sturm = new_sturm(crisp)
        for level in (-1.0, 0.0, 0.5, 0.9):
            counts = [count_below(crisp, wrench, level, turn, sturm) for turn in (QUICK, EXACT)]
            assert counts[0] == counts[1]
        assert counts[0] >= count_below(crisp, wrench, 0.0, QUICK, sturm) == 0
