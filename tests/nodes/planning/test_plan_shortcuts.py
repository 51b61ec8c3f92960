"""Short cuts: which are chosen, and that ways only get shorter and stay valid."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.planning.cavity import make_cavity, make_wall
from nodes.planning.plan_edges import Ground, find_valid, pick_ends, walk_edges
from nodes.planning.plan_paths import places_along, read_nodes
from nodes.planning.plan_shortcuts import choose_apart, shorten_path, smooth_path
from nodes.planning.plan_ways import join_edges
from tests.nodes.planning.made_motions import PLACED, bone_map, box_grid
from tests.nodes.planning.made_trees import distances, grow, joints, plan_parameters

DETOUR = [
    joints((15, 0, 0), (0, 5, 0), (5, 5)),
    joints((15, 12, 0), (6, 5, 0), (15, 15)),
    joints((-5, 14, 0), (4, -5, 0), (5, 10)),
]


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 9), st.integers(1, 5), st.integers(1, 50)), max_size=7))
def test_no_other_choice_of_pairs_that_do_not_overlap_gains_more(drawn):
    pairs = np.array([(first, first + size) for first, size, _ in drawn], int).reshape(-1, 2)
    gains = np.array([gain for *_, gain in drawn], float)
    chosen = choose_apart(pairs, gains)

    def apart(rows):
        return all(
            pairs[a, 1] <= pairs[b, 0] or pairs[b, 1] <= pairs[a, 0]
            for a, b in combinations(rows, 2)
        )

    every = (
        rows for size in range(len(drawn) + 1) for rows in combinations(range(len(drawn)), size)
    )
    best = max(gains[list(rows)].sum() for rows in every if apart(rows))
    assert apart(chosen) and gains[chosen].sum() == pytest.approx(best)
    assert np.all(np.diff(pairs[chosen, 0]) >= 0)


def ground_of(*walls, **changed):
    grid = box_grid(walls, 4.0)
    cavity = make_cavity(grid, distances(grid))
    return Ground(PLACED, cavity, make_wall(bone_map(), ()), plan_parameters(**changed))


def detour(ground):
    path, _ = join_edges(ground, read_nodes(grow(DETOUR, [0, 1, 2]), np.arange(4)), 1)
    return path


def is_valid(ground, path):
    """Whether each step along a way is reached from the one before it and is valid."""
    places = np.arange(len(path.lengths_mm))
    walked = walk_edges(ground, pick_ends(path, places[:-1], places[1:]))
    return find_valid(ground, walked).all()


def test_in_the_open_a_detour_becomes_the_straight_way():
    ground = ground_of()
    path = detour(ground)
    short = shorten_path(ground, path, np.random.default_rng(0))
    assert short.corners.tolist() == [0, len(short.lengths_mm) - 1]
    assert places_along(short, 57.0)[-1] < 0.6 * places_along(path, 57.0)[-1]


def test_ways_around_an_obstacle_get_shorter_stay_valid_and_end_where_they_did():
    wall = (np.array([-7.0, -1, 73]), np.array([-5.0, 5, 100]))
    open_ground, ground = ground_of(), ground_of(wall)
    path = detour(ground)
    short = shorten_path(ground, path, np.random.default_rng(0))
    smooth = smooth_path(ground, short)
    lengths = [places_along(way, 57.0)[-1] for way in (path, short, smooth)]
    assert lengths[0] > lengths[1] >= lengths[2]
    free = shorten_path(open_ground, path, np.random.default_rng(0))
    assert lengths[2] > places_along(free, 57.0)[-1] + 1
    for way in (short, smooth):
        assert is_valid(ground, way)
        for end in (0, -1):
            assert np.array_equal(way.orientations[end], path.orientations[end])
            assert np.array_equal(way.wrenches[end], path.wrenches[end])
