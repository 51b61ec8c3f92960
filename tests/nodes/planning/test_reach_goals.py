"""A proof that a goal cannot be seen is never wrong: rays and places are tried by brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from nodes.environment.measure_distance import measure_distance
from nodes.geometry.grids import LabelMap
from nodes.geometry.lines_of_sight import find_surface, sees
from nodes.geometry.origin import Origin
from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Needle, Snare
from nodes.planning.artefacts import PlacedSetup
from nodes.planning.parameters import ClearanceParameters
from nodes.planning.reach_goals import prove_unreachable
from tests.nodes.mechanics.made_robots import METAL

CLEARANCES = ClearanceParameters(
    margin_mm=0.5, sheath_mm=2.0, outside_mm=10.0, grasp_mm=5.0, sheath_avoids=(), piece_mm=8.0,
    coarsest_cell=9.0,
)  # fmt: skip
WIDE = "no place from which"


def make_grid(free):
    """An occupancy grid with cells of 1 mm."""
    near = ndimage.binary_dilation(free) & ~free
    voxels = np.where(free, 1, np.where(near, 2, 0)).astype(np.uint8)
    return LabelMap(voxels, np.eye(4), ("free", "boundary"), Origin("test"))


def setup_at(entry, longest=100.0, outer=1.0):
    needle = Needle(METAL, 0.0, outer, np.zeros(3))
    entries = np.array([entry, np.add(entry, [50.0, 0, 0])], float)
    setup = CrispSetup((needle, needle), entries, (Snare(1, 10.0),), 90.0)
    start = CrispConfiguration(np.repeat(np.eye(3)[None], 2, 0), np.array([20.0, 60.0]))
    axes, two = np.repeat([[0.0, 0, 1]], 2, 0), np.ones(2)
    return PlacedSetup("x", setup, start, axes, two, 0 * two, longest * two)


def prove(free, entry, camera, cell, longest=100.0, outer=1.0):
    grid = make_grid(free)
    cells = np.array(cell).reshape(-1, 3)
    placed = setup_at(entry, longest, outer)
    where = np.array(camera, float)
    return prove_unreachable(placed, where, grid, measure_distance(grid), cells, CLEARANCES)


def room(shape=(24, 20, 20)):
    free = np.zeros(shape, bool)
    free[2:-2, 2:-2, 2:-2] = True
    return free


def test_what_an_open_room_shows_is_not_called_unreachable():
    free = room()
    for cell in np.argwhere(make_grid(free).mask("boundary"))[::61]:
        assert prove(free, (12, 10, 2), (12, 10, 8), cell) == ""


def test_a_room_behind_a_door_narrower_than_the_tool_is_cut_off():
    free = room()
    free[11:13] = False
    free[11:13, 10, 10] = True
    aside = (12, 3, 3)  # on the door's wall, seen from beyond it only
    assert "too narrow" in prove(free, (6, 10, 2), (6, 10, 8), aside, outer=6.0)
    assert prove(free, (6, 10, 2), (6, 10, 8), aside, outer=0.5) == ""


def test_a_goal_farther_than_the_tool_is_long_is_out_of_reach():
    free = np.zeros((60, 9, 30), bool)
    free[2:40, 2:7, 2:7] = True
    free[35:40, 2:7, 2:28] = True  # round a corner
    cell = (34, 4, 26)
    assert "reaches 20 mm" in prove(free, (4, 4, 4), (8, 4, 4), cell, longest=20.0)
    assert prove(free, (4, 4, 4), (8, 4, 4), cell, longest=60.0) == ""


def test_a_goal_in_a_crack_is_seen_from_no_place_with_room():
    free = np.zeros((24, 30, 20), bool)
    free[2:-2, 2:18, 2:-2] = True
    free[12, 18:27, 10] = free[13, 26, 10] = True
    free[14, 25:27, 10] = True  # and back: no straight line from the room leads to its end
    reason = prove(free, (12, 10, 2), (12, 10, 8), (14, 24, 10), outer=3.0)
    assert reason.startswith(WIDE)
    assert prove(free, (12, 10, 2), (12, 10, 8), (12, 27, 10), outer=3.0) == ""


def test_a_cell_without_a_free_face_is_behind_others():
    free = room()
    grid = make_grid(free)
    corner = (1, 1, 5)
    assert not grid.mask("free")[corner]
    assert prove(free, (12, 10, 2), (12, 10, 8), (0, 0, 5)).startswith("no free cell")


def test_a_region_is_unreachable_only_if_all_of_it_is():
    free = room()
    assert prove(free, (12, 10, 2), (12, 10, 8), [(0, 0, 5)])
    assert prove(free, (12, 10, 2), (12, 10, 8), [(0, 0, 5), (12, 1, 10)]) == ""


@st.composite
def caves(draw):
    """Random free cells, a free cell for the camera, and a boundary cell."""
    seed = draw(st.integers(0, 2**32 - 1))
    random = np.random.default_rng(seed)
    free = np.zeros((12, 12, 12), bool)
    free[1:-1, 1:-1, 1:-1] = random.uniform(size=(10, 10, 10)) < draw(st.floats(0.3, 0.8))
    parts, _ = ndimage.label(free)
    free = parts == np.bincount(parts[free]).argmax() if free.any() else free
    return free, random


@settings(max_examples=40)
@given(caves())
def test_what_any_reachable_camera_sees_is_never_called_unreachable(cave):
    free, random = cave
    grid = make_grid(free)
    boundary, inside = np.argwhere(grid.mask("boundary")), np.argwhere(free)
    if not len(inside):
        return
    distance, surface = measure_distance(grid), find_surface(grid)
    radius, longest = random.uniform(0.05, 0.7), random.uniform(3, 12)
    start = inside[random.integers(len(inside))]
    entry = start + random.uniform(-0.4, 0.4, 3)
    placed = setup_at(entry, longest, 2 * radius)
    clearances = CLEARANCES.model_copy(update={"margin_mm": 0.0, "sheath_mm": 0.0})
    wide = (distance.voxels >= radius) & free
    parts, _ = ndimage.label(wide)  # centres of cells that hang together over faces: a real way
    if not parts[tuple(start)]:
        return
    reached = np.argwhere(parts == parts[tuple(start)])
    reached = reached[np.linalg.norm(reached - entry, axis=1) <= longest]
    for cell in boundary[random.integers(len(boundary), size=6)]:
        reason = prove_unreachable(
            placed, start.astype(float), grid, distance, cell[None], clearances
        )
        if reason:
            for camera in reached:
                way = (cell - camera) / np.linalg.norm(cell - camera)
                assert not sees(surface, camera.astype(float), way, 90.0, cell)


@pytest.mark.parametrize("seed", range(3))
def test_chains_are_those_of_plain_search_in_each_octant(seed):
    from nodes.kernels.monotone_chains import mark_chains

    random = np.random.default_rng(seed)
    free = random.uniform(size=(7, 6, 8)) < 0.6
    goal = (3, 2, 4)
    free[goal] = False
    goals, found = np.zeros(free.shape, np.uint8), np.zeros(free.shape, np.uint8)
    goals[goal] = 1
    mark_chains(free.astype(np.uint8), goals, found)
    expected = set()
    for signs in np.ndindex(2, 2, 2):
        stack = [goal]
        while stack:
            place = stack.pop()
            for axis, sign in enumerate(signs):
                near = list(place)
                near[axis] += 1 if sign else -1
                inside = all(0 <= c < n for c, n in zip(near, free.shape, strict=True))
                if inside and free[tuple(near)]:
                    stack.append(tuple(near))
                    expected.add(tuple(near))
    assert {tuple(cell) for cell in np.argwhere(found)} == expected
