"""Fast looks against one ray a cell, bit for bit; what is seen against closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.errors import BadInput
from nodes.geometry import lines_of_sight
from nodes.geometry.lines_of_sight import (
    find_surface,
    half_view,
    look,
    look_anew,
    look_plainly,
    sees,
)
from tests.nodes.geometry.made_surfaces import ellipsoid, hard_cameras, seeded_grids, to_grid

READINGS = ["own ray", "first hit"]
ANGLES = [5.0, 40.0, 70.0, 90.0, 120.0, 180.0]


def never(surface):
    return np.full(len(surface.cells), -1)


def by_rays(surface, cameras, views, angle, reading, first=0):
    found = never(surface)
    blind = look_plainly(surface, (cameras, views, half_view(angle)), reading, first, found)
    return found, blind


@pytest.mark.parametrize("reading", READINGS)
@settings(max_examples=60)
@given(seeded_grids(), st.sampled_from(ANGLES), st.booleans())
def test_fast_looks_are_those_of_one_ray_a_cell(reading, made, angle, corners):
    free, rng = made
    surface = find_surface(to_grid(free, corners=corners))
    cameras, views = hard_cameras(rng, free.shape, 30)
    found = never(surface)
    blind = look(surface, cameras, views, angle, reading, found, 7)
    expected, blind_too = by_rays(surface, cameras, views, angle, reading, 7)
    np.testing.assert_array_equal(found, expected)
    assert blind == blind_too


def folded_cavity():
    """An ellipsoid with a wall that has a window, thick and thin pillars and a slanted sheet."""
    free = ellipsoid((26, 19, 15))
    i, j, k = np.indices(free.shape)
    free &= ~((abs(i - 20) < 4) & ((j - 20) ** 2 + (k - 16) ** 2 > 30))
    free &= (i - 36) ** 2 + (j - 14) ** 2 > 12
    return free & ~((i + k == 52) & (j > 15))


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("angle", [40.0, 90.0, 140.0])
def test_fast_looks_in_a_folded_cavity_are_those_of_one_ray_a_cell(reading, angle):
    free, rng = folded_cavity(), np.random.default_rng(0)
    surface = find_surface(to_grid(free))
    cells = np.argwhere(free)
    cameras = cells[rng.integers(len(cells), size=200)] + rng.uniform(-0.5, 0.5, (200, 3))
    views = rng.normal(size=(200, 3))
    found = never(surface)
    look(surface, cameras, views, angle, reading, found)
    np.testing.assert_array_equal(found, by_rays(surface, cameras, views, angle, reading)[0])
    assert 0.3 < (found >= 0).mean() < 1


@pytest.mark.parametrize("reading", READINGS)
def test_batches_in_any_order_and_any_number_of_parts_give_the_same(reading, monkeypatch):
    free, rng = folded_cavity(), np.random.default_rng(1)
    surface = find_surface(to_grid(free))
    cells = np.argwhere(free)
    cameras = cells[rng.integers(len(cells), size=60)].astype(float)
    views = rng.normal(size=(60, 3))
    whole = never(surface)
    look(surface, cameras, views, 90.0, reading, whole)
    for parts, batches in ((1, [(0, 60)]), (5, [(40, 60), (3, 5), (5, 40), (0, 3)])):
        monkeypatch.setattr(lines_of_sight, "PARTS", parts)
        found = never(surface)
        for first, last in batches:
            look(surface, cameras[first:last], views[first:last], 90.0, reading, found, first)
        np.testing.assert_array_equal(found, whole)


def test_what_each_camera_sees_by_itself_does_not_depend_on_the_others():
    free, rng = folded_cavity(), np.random.default_rng(4)
    surface = find_surface(to_grid(free))
    cameras, views = hard_cameras(rng, free.shape, 40)
    seen = look_anew(surface, cameras, views, 100.0)
    for node in range(40):
        one = slice(node, node + 1)
        alone = by_rays(surface, cameras[one], views[one], 100.0, "own ray")[0]
        np.testing.assert_array_equal(seen[node], alone == 0)
    assert seen.any() and not seen.all(axis=0).any()


def test_one_look_and_many_looks_agree():
    free, rng = folded_cavity(), np.random.default_rng(2)
    matrix = np.diag([-1.5, 1.5, 1.5, 1.0])
    matrix[:3, 3] = 20.0, -3.0, 100.0
    surface = find_surface(to_grid(free, matrix))
    cells = np.argwhere(free)
    for camera in cells[rng.integers(len(cells), size=10)]:
        place, view = matrix[:3, :3] @ camera + matrix[:3, 3], rng.normal(size=3)
        found = by_rays(surface, place[None], view[None], 90.0, "own ray")[0]
        for cell in rng.integers(len(surface.cells), size=20):
            assert sees(surface, place, view, 90.0, surface.cells[cell]) == (found[cell] == 0)


@pytest.mark.parametrize("angle", [30.0, 60.0, 89.0])
def test_a_flat_wall_is_seen_where_the_cone_meets_it(angle):
    """From 20 cells before the wall, all cells whose centres are within the cone are seen."""
    free = np.zeros((24, 61, 61), bool)
    free[1:-1, 1:-1, 1:-1] = True
    surface = find_surface(to_grid(free))
    camera, view = np.array([[3.0, 30.0, 30.0]]), np.array([[1.0, 0.0, 0.0]])
    found = by_rays(surface, camera, view, angle, "own ray")[0]
    wall = surface.cells[:, 0] == 23
    away = np.hypot(*(surface.cells[wall, 1:] - 30.0).T)
    np.testing.assert_array_equal(found[wall] == 0, away <= 20 * np.tan(np.deg2rad(angle / 2)))


def test_behind_a_pillar_nothing_is_seen_and_before_it_all_that_was():
    free = np.zeros((40, 41, 41), bool)
    free[1:-1, 1:-1, 1:-1] = True
    before, after = find_surface(to_grid(free)), free.copy()
    after[18:21, 16:25, :] = False
    surface = find_surface(to_grid(after))
    camera, view = np.array([[5.0, 20.0, 20.0]]), np.array([[1.0, 0.0, 0.0]])
    clear = by_rays(before, camera, view, 70.0, "own ray")[0]
    found = by_rays(surface, camera, view, 70.0, "own ray")[0]
    seen = {tuple(cell) for cell in surface.cells[found == 0]}
    shadow = {
        tuple(cell)
        for cell, node in zip(before.cells, clear, strict=True)
        if node == 0 and cell[0] == 39 and abs(cell[1] - 20) < 4.5 * 34 / 15.5 - 1
    }
    lit = {
        tuple(cell)
        for cell, node in zip(before.cells, clear, strict=True)
        if node == 0 and cell[0] == 39 and abs(cell[1] - 20) > 4.5 * 34 / 12.5 + 1
    }
    assert shadow and lit and not (shadow & seen) and lit <= seen


def test_first_hits_hold_all_cells_that_are_seen_themselves():
    free, rng = folded_cavity(), np.random.default_rng(3)
    surface = find_surface(to_grid(free))
    cells = np.argwhere(free)
    cameras, views = cells[rng.integers(len(cells), size=9)].astype(float), rng.normal(size=(9, 3))
    own, hit = (by_rays(surface, cameras, views, 90.0, one)[0] for one in READINGS)
    assert ((hit >= 0) & (hit <= np.where(own < 0, 99, own)))[own >= 0].all()
    assert (hit >= 0).sum() > (own >= 0).sum()


def test_empty_surfaces_and_no_cameras_are_looked_at_without_complaint():
    full = find_surface(to_grid(np.ones((3, 3, 3), bool)))
    none = find_surface(to_grid(np.zeros((3, 3, 3), bool)))
    box = find_surface(to_grid(np.pad(np.ones((3, 3, 3), bool), 1)))
    for surface, count in ((full, 9), (none, 9), (box, 0)):
        for reading in READINGS:
            found, middles = never(surface), np.ones((count, 3))
            blind = look(surface, middles, middles, 90.0, reading, found)
            assert (found == -1).all() and blind == (count if surface is none else 0)


def test_cells_that_are_no_cubes_are_refused():
    with pytest.raises(BadInput, match="cubes"):
        find_surface(to_grid(np.ones((3, 3, 3), bool), np.diag([1.0, 1.0, 1.2, 1.0])))
