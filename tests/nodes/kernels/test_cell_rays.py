"""Lines of sight against exact fractions, against slabs, and from both ends."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from nodes.kernels.cell_rays import (
    NOWHERE,
    SHARES,
    aim_camera,
    first_obstacle,
    sees_cell,
)
from tests.nodes.geometry.made_surfaces import hard_cameras, seeded_grids
from tests.nodes.kernels.oracle_rays import ray_cells, slab_stops

ALL = 0.0  # squared cosine of half of 180 degrees
INDEX = np.eye(4)[:3].copy()


@njit
def meet(free, index_from_patient, camera, cell, begin):
    seer = aim_camera(free, index_from_patient, camera, np.ones(3), 0.0)
    if seer.place[0] == NOWHERE:
        return np.int64(-1), np.int64(-1), np.int64(-1)
    return first_obstacle(free, seer.place, cell[0], cell[1], cell[2], np.int64(begin))


def is_seen(free, camera, cell):
    towards = cell - camera
    if not towards.any():
        towards = np.ones(3)
    return sees_cell(free, INDEX, camera, towards, ALL, *cell.tolist())


@settings(max_examples=40)
@given(seeded_grids())
def test_rays_take_the_cells_that_exact_fractions_give(made):
    free, rng = made
    cells = rng.integers(0, free.shape, (40, 3))
    for camera, cell in zip(hard_cameras(rng, free.shape, 40)[0], cells, strict=True):
        way = ray_cells(camera, cell)
        inside = all(0 <= x < n for x, n in zip(way[0], free.shape, strict=True))
        sees = inside and free[way[0]]
        assert is_seen(free.astype(np.uint8), camera, cell) == (
            sees and all(free[place] for place in way[:-1])
        )
        met = meet(free.astype(np.uint8), INDEX, camera, cell, 0)
        first = next((place for place in way if not free[place]), way[-1]) if sees else (-1,) * 3
        assert met == first


@settings(max_examples=40)
@given(seeded_grids())
def test_rays_without_ties_are_free_if_no_box_is_on_the_straight_way(made):
    free, rng = made
    asked = 0
    for _ in range(30):
        camera = rng.uniform(-0.5, np.array(free.shape) - 0.5)
        cell = rng.integers(0, free.shape)
        others = free.copy()
        others[tuple(cell)] = True
        start = tuple(np.floor(camera + 0.5).astype(int))
        stops = slab_stops(camera, cell, np.argwhere(~others))
        if not free[start] or stops is None:
            continue
        asked += 1
        assert is_seen(free.astype(np.uint8), camera, cell) == (not stops)
    assert asked or not free.any() or free.mean() < 0.9


@settings(max_examples=30)
@given(seeded_grids())
def test_what_is_met_does_not_depend_on_where_in_the_free_part_tracing_begins(made):
    free, rng = made
    free8, cells = free.astype(np.uint8), rng.integers(0, free.shape, (20, 3))
    for camera, cell in zip(hard_cameras(rng, free.shape, 20)[0], cells, strict=True):
        met = meet(free8, INDEX, camera, cell, 0)
        if met[0] < 0:
            continue
        way = ray_cells(camera, cell)
        start = (np.round((camera + 0.5) * 65536) / 65536).astype(float)
        length = np.abs(np.array(cell) + 0.5 - start).sum()
        reached = way.index(met)  # so many faces are crossed: at least this share is done
        share = max(0.0, (reached - 3) / max(length, 1.0))
        begin = int(rng.uniform(0, min(share, 1.0)) * SHARES)
        assert meet(free8, INDEX, camera, cell, begin) == met


@given(st.integers(0, 10_000), st.sampled_from([0.3, 1.0, 2.5]))
def test_turned_and_mirrored_grids_are_seen_alike(seed, side):
    rng = np.random.default_rng(seed)
    free = rng.random((6, 7, 8)) < 0.9
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    patient_from_index = np.eye(4)
    patient_from_index[:3, :3], patient_from_index[:3, 3] = axes * side, rng.normal(size=3) * 50
    matrix = np.linalg.inv(patient_from_index)[:3].copy()
    for cell in rng.integers(0, free.shape, (10, 3)):
        camera, view = rng.uniform(0.6, 5.4, 3), rng.normal(size=3)
        half = float(rng.uniform(0, 1))
        turned = patient_from_index[:3, :3] @ camera + patient_from_index[:3, 3]
        straight = sees_cell(free.astype(np.uint8), INDEX, camera, view, half, *cell.tolist())
        assert straight == sees_cell(
            free.astype(np.uint8), matrix, turned, axes @ view, half, *cell.tolist()
        )


def test_cameras_beyond_the_grid_or_in_obstacles_see_nothing():
    free = np.ones((4, 4, 4), np.uint8)
    free[1, 1, 1] = 0
    target = np.array([3, 3, 3])
    for camera in ([-0.6, 1, 1], [1, 1, 3.5], [1, 1, 1e300], [np.nan, 1, 1], [1, 1, 1]):
        assert not is_seen(free, np.array(camera, float), target)
    assert is_seen(free, np.array([-0.5, 2, 2]), target)


def test_field_of_view_ends_at_half_its_angle():
    free = np.ones((30, 30, 3), np.uint8)
    camera, view = np.array([0.0, 0.0, 1.0]), np.array([2.0, 0.0, 0.0])
    for degrees in (20, 50, 70, 120):
        half = (1 + np.cos(np.deg2rad(degrees))) / 2
        for i, j in np.ndindex(29, 29):
            angle = np.degrees(np.arctan2(j, i + 1))
            if abs(angle - degrees / 2) > 1e-9:
                seen = sees_cell(free, INDEX, camera, view, half, i + 1, j, 1)
                assert seen == (angle < degrees / 2)
