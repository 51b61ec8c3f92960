"""Chains are what the solver finds for each configuration alone, up to where there is none."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nodes.mechanics.crisp_states import sample
from nodes.mechanics.robots import CrispConfiguration
from nodes.mechanics.solve_crisp import solve_crisp, step_turn, to_crisp
from nodes.mechanics.solve_crisp_batch import sample_crisp_batch, solve_crisp_batch
from tests.nodes.mechanics.crisp_reference import CASES, case_robot, case_wrenches
from tests.nodes.mechanics.test_solve_crisp import parameters

ACCURACY = 1e-3


def chain_of(name: str, steps: int = 6, turn: float = 0.01, longer: float = 0.3):
    """All needles turn about an axis and grow, a little each step."""
    setup, configuration = case_robot(CASES[name])
    turns = Rotation.from_rotvec(turn * np.arange(steps)[:, None] * [0.6, 0, 0.8]).as_matrix()
    frames = turns[:, None] @ configuration.patient_from_entry
    lengths = configuration.lengths_mm + longer * np.arange(steps)[:, None]
    return setup, frames, lengths, case_wrenches(CASES[name])


@pytest.mark.parametrize("name", ["rigid1_2", "relaxed1_1", "rigid2_2"])
def test_each_configuration_is_solved_as_alone(name) -> None:
    setup, frames, lengths, seed = chain_of(name)
    chosen = parameters(margin_accuracy=ACCURACY)
    chain = solve_crisp_batch(setup, frames, lengths, seed, chosen)
    assert chain.lost == "" and len(chain.margins) == len(frames)
    exact = parameters()
    for row, (turns, reach) in enumerate(zip(frames, lengths, strict=True)):
        alone = solve_crisp(setup, CrispConfiguration(turns, reach), exact, chain.wrenches[row])
        assert chain.wrenches[row] == pytest.approx(alone.base_wrenches, abs=1e-7)
        assert chain.margins[row] == pytest.approx(alone.stability_margin, abs=ACCURACY)


def test_samples_are_those_of_each_configuration_alone() -> None:
    setup, frames, lengths, seed = chain_of("rigid2_2", steps=3)
    chosen = parameters(margin_accuracy=ACCURACY)
    chain = solve_crisp_batch(setup, frames, lengths, seed, chosen)
    places = tuple(np.linspace(0, 1, 5) * own[:, None] for own in lengths.T)
    states = sample_crisp_batch(setup, frames, lengths, chain.wrenches, places, chosen.tolerance_mm)
    for row in range(3):
        crisp = to_crisp(setup, CrispConfiguration(frames[row], lengths[row]))
        for needle, found in enumerate(states):
            reach = step_turn(crisp, chosen.tolerance_mm)
            alone = sample(crisp, chain.wrenches[row], needle, places[needle][row], reach)
            assert found[row, :, :3] == pytest.approx(alone.points_patient_mm, abs=1e-9)
            axes = np.swapaxes(alone.patient_from_body, 1, 2).reshape(-1, 9)
            assert found[row, :, 3:12] == pytest.approx(axes, abs=1e-9)
            assert found[row, :, 12:] == pytest.approx(alone.wrenches, abs=1e-9)


def test_a_margin_is_found_wherever_the_last_one_was() -> None:
    """One long step, over which the margin changes by more than is looked at first."""
    setup, frames, lengths, seed = chain_of("relaxed1_1", steps=2, turn=0.15, longer=5.0)
    chosen = parameters(margin_accuracy=ACCURACY)
    forth = solve_crisp_batch(setup, frames, lengths, seed, chosen)
    back = solve_crisp_batch(setup, frames[::-1], lengths[::-1], forth.wrenches[1], chosen)
    assert abs(forth.margins[0] - forth.margins[1]) > 4 * ACCURACY
    assert back.margins[::-1] == pytest.approx(forth.margins, abs=2 * ACCURACY)


def test_a_chain_ends_where_needles_are_too_short_to_meet() -> None:
    setup, frames, lengths, seed = chain_of("rigid1_2", turn=0.0)
    lengths = np.array(lengths)
    lengths[3:, 1] = 1.0
    chain = solve_crisp_batch(setup, frames, lengths, seed, parameters())
    assert len(chain.margins) == 3 and "no solution" in chain.lost


def test_a_seed_that_leads_nowhere_ends_it_at_once() -> None:
    setup, frames, lengths, seed = chain_of("rigid2_2")
    wild = 1e3 * np.random.default_rng(1).normal(size=seed.shape)
    chain = solve_crisp_batch(setup, frames, lengths, wild, parameters())
    assert len(chain.margins) == 0 and "not converged" in chain.lost
