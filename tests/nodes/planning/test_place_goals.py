"""Goals are cells of the surface: marked points, painted regions, random places."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from nodes.geometry.sites import Sites
from nodes.planning.parameters import PlaceGoalsParameters
from nodes.planning.place_goals import place_goals
from nodes.planning.surface_cells import find_surface_cells
from tests.nodes.planning.made_cavity import chest, occupancy, place

CHEST = chest()
GRID, _ = occupancy(CHEST)
CELL = 2.0


def parameters(**changed):
    values = {"snap_mm": 5.0, "goal_labels": (), "random_goals": 0, "seed": 0}
    return PlaceGoalsParameters(**{**values, **changed})


def points(*places, names=None):
    names = names or tuple(f"point {n}" for n in range(len(places)))
    marked = np.array(places, float).reshape(-1, 3)
    return Sites(point_names=names, points_patient_mm=marked, origin=Origin("marks"))


def centre(cell):
    return GRID.patient_from_index[:3, :3] @ cell + GRID.patient_from_index[:3, 3]


def distances(point):
    """Distance from a point to the box of each surface cell, cell by cell."""
    found = []
    for cell in find_surface_cells(GRID):
        low, high = centre(cell) - CELL / 2, centre(cell) + CELL / 2
        found.append(np.linalg.norm(point - np.clip(point, low, high)))
    return np.array(found)


def test_surface_cells_are_boundary_cells_with_a_free_face():
    free, boundary = GRID.mask("free"), GRID.mask("boundary")
    expected = []
    for i, j, k in np.argwhere(boundary):
        sides = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
        near = [tuple(np.add((i, j, k), side)) for side in sides]
        inside = [n for n in near if min(n) >= 0 and all(np.less(n, free.shape))]
        if any(free[n] for n in inside):
            expected.append((i, j, k))
    np.testing.assert_array_equal(find_surface_cells(GRID), expected)


@settings(max_examples=25)
@given(st.tuples(st.floats(9, 50), st.floats(9, 45), st.floats(9, 55)))
def test_a_point_is_the_nearest_cell_or_refused_with_the_nearest_place(voxel):
    point = place(*voxel)
    least = distances(point).min()
    if least > 5.0 + 1e-6:
        with pytest.raises(BadInput, match=r"off the surface") as error:
            place_goals(points(point), CHEST, GRID, parameters())
        assert f"{least:.1f} mm" in error.value.value
    elif least < 5.0 - 1e-6:
        goals = place_goals(points(point), CHEST, GRID, parameters())
        assert len(goals.cells) == 1
        apart = np.abs(point - centre(goals.cells[0])) - CELL / 2
        assert np.linalg.norm(np.maximum(apart, 0)) == pytest.approx(least, abs=1e-6)
        np.testing.assert_array_equal(goals.points_patient_mm, [point])


def test_the_offered_place_is_on_the_surface_in_both_frames():
    with pytest.raises(BadInput) as error:
        place_goals(points(place(30, 27, 32), names=("spot",)), CHEST, GRID, parameters())
    said = error.value.cure.replace(",", " ").split()
    numbers = [float(word) for word in said if word.lstrip("-").replace(".", "", 1).isdigit()]
    lps, ras = np.array(numbers[:3]), np.array(numbers[3:6])
    np.testing.assert_allclose(ras * [-1, -1, 1], lps)
    assert place_goals(points(lps), CHEST, GRID, parameters(snap_mm=0.1)).names == ("point 0",)


def test_poses_count_by_their_place_and_come_first():
    pose = np.eye(4)
    pose[:3, 3] = place(20, 11, 20)
    sites = replace(points(place(30, 11, 30)), pose_names=("begin",), patient_from_site=pose[None])
    goals = place_goals(sites, CHEST, GRID, parameters())
    assert goals.names == ("begin", "point 0") and goals.goals.tolist() == [0, 1]


def painted(mask):
    voxels = CHEST.voxels.copy()
    voxels[mask] = 5
    names = (*CHEST.names, "patch")
    return LabelMap(voxels, CHEST.patient_from_index, names, Origin("painted"))


def test_a_painted_region_is_all_cells_within_half_a_cell_of_it():
    mask = np.zeros(CHEST.voxels.shape, bool)
    mask[20:26, 10:12, 20:30] = True
    goals = place_goals(Sites(), painted(mask), GRID, parameters(goal_labels=("patch",)))
    expected = []
    for cell in find_surface_cells(GRID):
        index = (centre(cell) - CHEST.patient_from_index[:3, 3]) / 2.0
        gaps = np.maximum(np.abs(np.argwhere(mask) - index) - 0.5, 0) * 2.0
        if np.linalg.norm(gaps, axis=1).min() <= CELL / 2:
            expected.append(tuple(cell))
    assert 40 < len(expected) < 200
    assert {tuple(cell) for cell in goals.cells} == set(expected)
    assert goals.goals.tolist() == [0] * len(expected)
    offsets = np.linalg.norm([centre(c) - goals.points_patient_mm[0] for c in goals.cells], axis=1)
    assert offsets.min() < 1e-9


def test_regions_off_the_surface_and_unknown_ones_are_refused():
    mask = np.zeros(CHEST.voxels.shape, bool)
    mask[25:28, 25:28, 25:28] = True
    with pytest.raises(BadInput, match="no place on the surface"):
        place_goals(Sites(), painted(mask), GRID, parameters(goal_labels=("patch",)))
    with pytest.raises(BadInput, match="body, bone, effusion, lung"):
        place_goals(Sites(), CHEST, GRID, parameters(goal_labels=("spot",)))


def test_random_goals_are_told_and_repeat_with_their_seed():
    one, same = (place_goals(Sites(), CHEST, GRID, parameters(random_goals=5)) for _ in range(2))
    other = place_goals(Sites(), CHEST, GRID, parameters(random_goals=5, seed=1))
    np.testing.assert_array_equal(one.cells, same.cells)
    assert not np.array_equal(one.cells, other.cells)
    assert one.names == tuple(f"random {n}" for n in range(1, 6))
    assert len({tuple(cell) for cell in one.cells}) == 5
    assert any("at random" in notice for notice in one.origin.notices)


def test_no_goals_at_all_are_allowed_and_told():
    goals = place_goals(Sites(), CHEST, GRID, parameters())
    assert goals.names == () and goals.cells.shape == (0, 3)
    assert any("no goal is given" in notice for notice in goals.origin.notices)
