"""Bent rods lie within the bound of their chords: solved robots, sampled finely."""

import numpy as np
import pytest
from numba import njit

from nodes.kernels.crisp_collision import FEWEST_PIECES
from nodes.kernels.crisp_collision_bends import chord_turn, rod_turn
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.sample_crisp_needles import sample_crisp_needles
from tests.nodes.mechanics.crisp_reference import CASES, case_robot, case_wrenches
from tests.nodes.mechanics.made_crisp_edges import PARAMETERS, edges_from

FINER = 24


@njit
def turns_of(points, first, pieces):
    """Return the bounds of all chords of a rod, and the bound of the rod."""
    found = np.empty(pieces)
    for place in range(pieces):
        found[place] = chord_turn(points, first + place, first, pieces)
    return found, rod_turn(points, first, pieces)


def rods_of(name, pieces):
    """Return fine points (rod, pieces * FINER + 1, 3) of a published case and its surroundings."""
    setup, configuration = case_robot(CASES[name], "tip")
    frames, lengths = configuration.patient_from_entry, configuration.lengths_mm
    edges = edges_from(frames, lengths, case_wrenches(CASES[name]), count=20, steps=6, step=2.0)
    tracks = follow_crisp_edges(setup, edges, PARAMETERS)
    solved = (tracks.status == 0).all(axis=1)
    fine = sample_crisp_needles(
        setup, edges.ends[solved], edges.end_lengths_mm[solved], tracks.wrenches[solved, -1],
        pieces * FINER,
    )  # fmt: skip
    count, joints = len(fine.tool_patient_mm), fine.snares_patient_mm.shape[1]
    along = pieces * FINER
    tools = [fine.tool_patient_mm[:, j * along : (j + 1) * along + 1] for j in range(joints)]
    return np.concatenate([*tools, fine.snares_patient_mm.reshape(count * joints, -1, 3)])


def bend_of(fine):
    """Return the largest distance between a rod's piece and its chord."""
    chord = fine[-1] - fine[0]
    off = fine - fine[0]
    along = np.clip(off @ chord / (chord @ chord), 0, 1)
    return np.linalg.norm(off - along[:, None] * chord, axis=1).max()


@pytest.mark.parametrize("name", ["rigid1_0", "rigid2_2", "relaxed2_paper_1", "relaxed1_3"])
@pytest.mark.parametrize("pieces", [FEWEST_PIECES, 11])
def test_pieces_lie_within_the_bound_of_their_chords(name, pieces):
    most = 0.0
    for rod in rods_of(name, pieces):
        points = np.ascontiguousarray(rod[::FINER])
        turns, whole = turns_of(points, 0, pieces)
        assert whole >= turns.max() * (1 - 1e-9)
        if whole > 0.5:  # is refused by those who use it
            continue
        for piece, turn in enumerate(turns):
            part = rod[piece * FINER : (piece + 1) * FINER + 1]
            length = np.linalg.norm(part[-1] - part[0])
            bent = bend_of(part)
            assert bent <= turn * length / 8 + 1e-9
            arc = np.linalg.norm(np.diff(part, axis=0), axis=1).sum()
            assert arc <= 1.02 * length
            most = max(most, bent / (turn * length / 8 + 1e-9))
    assert most > 0.5  # the bound is not idle
