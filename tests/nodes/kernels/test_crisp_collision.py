"""Needles against boxes and one another: brute force over all cells, and closed forms."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.optimize import minimize

from nodes.kernels.crisp_collision import (
    FEWEST_PIECES,
    FREE,
    NEEDLES_TOUCH,
    SHEATH_TOUCHES,
    TOUCHES_ANATOMY,
    Rules,
    step_is_free,
)
from nodes.kernels.crisp_collision_needles import square_between
from nodes.planning.cavity import make_cavity, make_wall
from tests.nodes.kernels.made_spaces import (
    MADE,
    LabelMap,
    capsule_distance,
    grid_of,
    taken_cells,
    turned_affine,
)

NO_SNARES = np.zeros((0, FEWEST_PIECES + 1, 3))
NO_WALL = make_wall(LabelMap(np.zeros((1, 1, 1), np.uint8), np.eye(4), (), MADE), ())
Z = np.array([[0.0, 0, 1]])


@njit
def _between(off, one, other):
    return square_between(off, one, other)


def rules(*radii, margin=0.0, sheath=0.0, grasp=0.0, outside=0.0):
    return Rules(np.array(radii, float), margin, sheath, grasp, outside)


def straight(start, end, pieces=FEWEST_PIECES):
    """Return points of a straight needle."""
    share = np.linspace(0, 1, pieces + 1)[:, None]
    return np.array(start, float) + share * (np.array(end, float) - start)


def look(cavity, start, end, radius, **options):
    tool = np.array([start, end], float)
    return step_is_free(tool, NO_SNARES, Z, rules(radius, **options), cavity, NO_WALL)


def open_box(shape=(12, 12, 12), spacing=1.0):
    """Return a cavity that is free but for its border cells, indices along patient axes."""
    free = np.zeros(shape, bool)
    free[1:-1, 1:-1, 1:-1] = True
    affine = np.diag([spacing, spacing, spacing, 1.0])
    return make_cavity(*grid_of(free, affine))


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10**6))
def test_a_needle_is_free_exactly_when_no_box_is_nearer_than_its_radius(seed):
    rng = np.random.default_rng(seed)
    free = rng.random(rng.integers(3, 8, 3)) < rng.choice([0.7, 0.95, 1.0])
    affine = turned_affine(rng, rng.uniform(0.4, 2.5, 3), seed % 3 > 0)
    cavity = make_cavity(*grid_of(free, affine))
    places = rng.uniform(-0.7, np.array(free.shape) - 0.3, (2, 3))
    start, end = places @ affine[:3, :3].T + affine[:3, 3]
    exact = capsule_distance(start, end, taken_cells(free, 1), affine)
    for radius in (0.5 * exact, exact - 1e-7, exact + 1e-7, 1.5 * exact, 0.3):
        if abs(radius - exact) > 1e-8 and radius > 0:
            found = look(cavity, start, end, radius)
            assert found == (FREE if radius < exact else TOUCHES_ANATOMY), (radius, exact)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6))
def test_needles_along_edges_and_through_corners_of_cells_are_measured_exactly(seed):
    """Places on a lattice of half cells meet boxes at faces, edges and corners, with no slope."""
    rng = np.random.default_rng(seed)
    free = rng.random((5, 5, 5)) < 0.9
    affine = np.diag([1.0, 1.0, 1.0, 1.0])
    cavity = make_cavity(*grid_of(free, affine))
    start, end = rng.integers(0, 9, (2, 3)) / 2.0
    exact = capsule_distance(start, end, taken_cells(free, 1), affine)
    for radius in (exact - 1e-9, exact + 1e-9, 0.01):
        if radius > 0 and radius != exact:
            found = look(cavity, start, end, radius)
            assert found == (FREE if radius < exact else TOUCHES_ANATOMY), (radius, exact)


def test_a_tube_thinner_than_a_cell_fits_between_two_cells_that_a_wider_one_touches():
    free = np.ones((7, 7, 7), bool)
    free[3, 2], free[3, 4] = False, False
    cavity = make_cavity(*grid_of(free, np.eye(4)))
    assert look(cavity, (1, 3, 3), (5, 3, 3), 0.499) == FREE
    assert look(cavity, (1, 3, 3), (5, 3, 3), 0.501) == TOUCHES_ANATOMY


def test_the_last_cells_of_the_grid_and_what_lies_beyond_count():
    cavity = make_cavity(*grid_of(np.ones((6, 6, 6), bool), np.eye(4)))
    for axis in range(3):
        for side, outward in ((-0.5, -1), (5.5, 1)):
            place = np.full(3, 2.5)
            place[axis] = side - outward * 1.0
            assert look(cavity, place, np.full(3, 2.5), 0.999) == FREE
            assert look(cavity, place, np.full(3, 2.5), 1.001) == TOUCHES_ANATOMY


def test_the_round_cap_at_the_tip_counts():
    cavity = open_box()
    assert look(cavity, (5, 5, 3), (5, 5, 9.4), 1.0) == FREE  # the wall is at 10.5
    assert look(cavity, (5, 5, 3), (5, 5, 9.6), 1.0) == TOUCHES_ANATOMY


def test_nan_is_not_free():
    assert look(open_box(), (5, 5, 3), (5, 5, np.nan), 0.5) == TOUCHES_ANATOMY


@pytest.mark.parametrize("slant", [0.0, 0.4])
def test_a_needle_leaves_its_sheath_where_it_first_touches_nothing(slant):
    """From 2 mm inside the wall the ball is free after (2 + radius) / cosine."""
    cavity, cosine = open_box((16, 16, 16)), np.cos(slant)
    way = np.array([np.sin(slant), 0, cosine])
    start = np.array([6.0, 8, 0.5 - 2.0])
    needed = (2.0 + 0.7) / cosine
    for sheath, code in ((needed + 0.06, FREE), (needed - 0.01, TOUCHES_ANATOMY)):
        assert look(cavity, start, start + 12 * way, 0.7, sheath=sheath) == code


def test_a_needle_that_touches_again_after_its_sheath_is_not_free():
    free = np.zeros((16, 16, 16), bool)
    free[1:-1, 1:-1, 1:-1] = True
    free[:, :, 4] = False
    cavity = make_cavity(*grid_of(free, np.eye(4)))
    assert look(cavity, (8, 8, -1), (8, 8, 12), 0.3, sheath=20.0) == TOUCHES_ANATOMY
    assert look(cavity, (8, 8, 5), (8, 8, 12), 0.3, sheath=20.0) == FREE


def test_the_margin_is_added_to_the_radius():
    cavity = open_box()
    assert look(cavity, (5, 5, 3), (5, 5, 9), 0.5, margin=0.9) == FREE
    assert look(cavity, (5, 5, 3), (5, 5, 9), 0.5, margin=1.1) == TOUCHES_ANATOMY


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10**6))
def test_distance_between_segments_is_the_least(seed):
    rng = np.random.default_rng(seed)
    off, one, other = rng.integers(-3, 4, (3, 3)) * 1.0 if seed % 2 else rng.normal(size=(3, 3))

    def square(shares):
        return np.sum((off + shares[0] * one - shares[1] * other) ** 2)

    begin = min(((s, t) for s in (0, 0.5, 1) for t in (0, 0.5, 1)), key=square)
    slow = minimize(square, begin, bounds=((0, 1), (0, 1)), tol=1e-14).fun
    assert _between(tuple(off), tuple(one), tuple(other)) == pytest.approx(slow, abs=1e-7)


@cache
def wide():
    """A cavity far from all needles below."""
    free = np.ones((10, 10, 10), bool)
    return make_cavity(*grid_of(free, np.diag([40.0, 40, 40, 1])))


def needles(cavity, tool, snares, grasp=0.0, radius=0.5, outside=0.0, wall=NO_WALL):
    """Return the code of straight needles, each cut into the fewest pieces."""
    chains = np.array([straight(*snare) for snare in snares])
    joints = len(snares)
    start, end = (np.array(place, float) for place in tool)
    share = np.linspace(0, 0.9, FEWEST_PIECES * joints + 1)[:, None]
    points = np.vstack([start + share * (end - start), end])
    ways = np.array([end - start, *(chain[-1] - chain[0] for chain in chains)])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    ruled = rules(*[radius] * (joints + 1), grasp=grasp, outside=outside)
    return step_is_free(points, chains, ways, ruled, cavity, wall)


def test_a_snare_may_touch_the_tool_that_it_grasps_but_only_there():
    cavity, tool = wide(), ((100, 100, 100), (200, 100, 100))
    assert needles(cavity, tool, [((190, 160, 100), (190, 100, 100))], grasp=1.01) == FREE
    assert needles(cavity, tool, [((190, 160, 100), (190, 100, 100))], grasp=0.99) == NEEDLES_TOUCH
    crossing = [((120, 160, 100), (120, 95, 100))]
    assert needles(cavity, tool, crossing, grasp=4.0) == NEEDLES_TOUCH
    assert needles(cavity, tool, crossing, grasp=6.01) == FREE


@pytest.mark.parametrize("gap, code", [(1.01, FREE), (0.99, NEEDLES_TOUCH)])
def test_snares_keep_apart_by_their_radii(gap, code):
    snares = [
        ((150, 160, 100), (150, 102, 100)),
        ((120, 130, 100 + gap), (180, 130, 100 + gap)),
    ]
    assert needles(wide(), ((100, 100, 100), (200, 100, 100)), snares) == code


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_needles_touch_exactly_when_their_axes_are_nearer_than_the_radii(seed):
    rng = np.random.default_rng(seed)
    tool, snare = rng.uniform(150, 200, (2, 2, 3))
    off, one, other = snare[0] - tool[0], snare[1] - snare[0], tool[1] - tool[0]

    def apart(shares):
        return np.sum((off + shares[0] * one - shares[1] * other) ** 2)

    begins = [(s, t) for s in (0.1, 0.9) for t in (0.1, 0.9)]
    least = min(minimize(apart, b, bounds=((0, 1), (0, 1)), tol=1e-15).fun for b in begins) ** 0.5
    cavity = wide()
    for radius, code in ((least / 2 - 1e-3, FREE), (least / 2 + 1e-3, NEEDLES_TOUCH)):
        if 1e-3 < radius < 60:
            assert needles(cavity, tool, [snare], radius=radius) == code


@pytest.mark.parametrize("clear, code", [(0.51, FREE), (0.49, SHEATH_TOUCHES)])
def test_a_sheath_keeps_from_bone_behind_the_entry_and_no_further(clear, code):
    """Bone lies beside the line behind the tool's entry, 20 mm away from it."""
    bone = np.zeros((60, 20, 20), np.uint8)
    bone[30, 10, 10] = 1
    names = LabelMap(bone, np.diag([1.0, 1, 1, 1]), ("bone",), MADE)
    wall = make_wall(names, ("bone",))
    tool = ((50, 10.5 + clear, 10), (90, 10.5 + clear, 10))
    free_snare = [((80, 60, 10), (80, 30, 10))]
    cavity = wide()
    assert needles(cavity, tool, free_snare, outside=30.0, wall=wall) == code
    assert needles(cavity, tool, free_snare, outside=18.9, wall=wall) == FREE
    assert needles(cavity, tool, free_snare, outside=500.0, wall=wall) == code
