"""Edges near folds and with taut snares, where equilibria change fast or cease to be."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.mechanics_cases import offset_configuration, random_crisp
from benchmarks.mechanics_edges import edges_between, ends_of, random_targets
from nodes.kernels.crisp_general_problem import pack
from nodes.kernels.crisp_stability import new_sturm, stability_margin
from nodes.mechanics.crisp_edges import BEYOND, BRANCH_ENDS, SOLVED, CrispEdges
from nodes.mechanics.follow_crisp_edges import follow_crisp_edges
from nodes.mechanics.robots import CrispConfiguration
from nodes.mechanics.solve_crisp import to_crisp
from tests.nodes.mechanics import oracle_crisp
from tests.nodes.mechanics.made_crisp_edges import PARAMETERS
from tests.nodes.mechanics.oracle_crisp_rods import robot_of

# Random robots and pairs of targets, found by trying thousands.
FOLDS = [
    (("rigid", "relaxed"), 512, 8),
    (("rigid", "rigid"), 509, 60),
    (("relaxed", "relaxed"), 506, 17),
]
TAUT = [(("relaxed", "relaxed"), 505, 15), (("rigid", "rigid"), 505, 9)]
JUMPS = [
    (("relaxed", "relaxed"), 506, 23),
    (("rigid", "relaxed"), 514, 54),
    (("rigid", "rigid"), 513, 14),
]


def follow_between(joints, seed, edge, parameters=PARAMETERS):
    """Return a robot's way to the first of two targets and on to the second."""
    chance = np.random.default_rng(seed)
    setup, first = random_crisp(chance, joints)
    there, beyond = (random_targets(chance, len(joints) + 1, 64)[[edge]] for _ in range(2))
    arrive = edges_between(first, 0 * there, there)
    arrived = follow_crisp_edges(setup, arrive, parameters)
    legs = [(0 * there, there, arrive, arrived)]
    seeds = ends_of(arrive, arrived)
    if not np.isnan(seeds).any():
        leave = replace(edges_between(first, there, beyond), start_wrenches=seeds)
        legs.append((there, beyond, leave, follow_crisp_edges(setup, leave, parameters)))
    return setup, first, legs


def at_share(edges, share):
    """Return the configuration at a share of the one edge."""
    way = Rotation.from_matrix(edges.ends[0] @ edges.starts[0].swapaxes(-1, -2)).as_rotvec()
    lengths = (1 - share) * edges.start_lengths_mm[0] + share * edges.end_lengths_mm[0]
    return CrispConfiguration(
        Rotation.from_rotvec(share * way).as_matrix() @ edges.starts[0], lengths
    )


def piece_of(edges, near, far, wrenches):
    """Return the part of the one edge between two shares as an edge of one step."""
    starts, ends = at_share(edges, near), at_share(edges, far)
    return CrispEdges(
        starts.patient_from_entry[None], ends.patient_from_entry[None], starts.lengths_mm[None],
        ends.lengths_mm[None], np.array(wrenches)[None], np.array([1]),
    )  # fmt: skip


def margin_at(setup, edges, share, wrenches):
    robot = pack(to_crisp(setup, at_share(edges, share)))
    return stability_margin(robot, wrenches.copy(), 1e-6, new_sturm(robot))


@pytest.mark.parametrize("joints, seed, edge", FOLDS)
def test_a_branch_ends_where_its_stability_margin_falls_to_zero(joints, seed, edge):
    setup, _, legs = follow_between(joints, seed, edge)
    _, _, edges, tracks = legs[-1]
    last = int((tracks.status[0] == SOLVED).sum()) - 1
    assert tracks.status[0, last + 1] == BRANCH_ENDS
    assert (tracks.status[0, last + 2 :] == BEYOND).all()
    low, high = last / edges.steps[0], (last + 1) / edges.steps[0]
    wrenches = tracks.wrenches[0, last]
    first = margin_at(setup, edges, low, wrenches)
    for _ in range(12):
        middle = (low + high) / 2
        tried = follow_crisp_edges(setup, piece_of(edges, low, middle, wrenches), PARAMETERS)
        assert tried.status[0, 1] in (SOLVED, BRANCH_ENDS)
        if tried.status[0, 1] == SOLVED:
            low, wrenches = middle, tried.wrenches[0, 1]
        else:
            high = middle
    assert 0 < margin_at(setup, edges, low, wrenches) < 0.1 * first


@pytest.mark.parametrize("joints, seed, edge", TAUT)
def test_taut_snares_are_followed_to_what_the_oracle_finds(joints, seed, edge):
    finer = PARAMETERS.model_copy(update={"refinements": 3})
    setup, first, legs = follow_between(joints, seed, edge, finer)
    _, target, edges, tracks = legs[1]
    assert (tracks.status[0, : edges.steps[0] + 1] == SOLVED).all()
    robot = robot_of(setup, offset_configuration(first, target[0]))
    slow = oracle_crisp.polish(robot, ends_of(edges, tracks)[0])
    camera = tracks.patient_from_camera[0, edges.steps[0]]
    assert np.abs(camera[:3, 3] - slow.tip_point).max() < 1e-6


@pytest.mark.parametrize("joints, seed, edge", JUMPS)
def test_tracks_do_not_jump_across_folds(joints, seed, edge):
    setup, _, legs = follow_between(joints, seed, edge)
    for _, _, edges, tracks in legs:
        for step in np.flatnonzero(tracks.status[0] == SOLVED):
            wrenches = tracks.wrenches[0, step]
            assert margin_at(setup, edges, step / edges.steps[0], wrenches) > 0
