"""Shafts of free and solid cells: what is said of all rays in one holds of each that is traced."""

import numpy as np
from numba import njit

from nodes.geometry.lines_of_sight import find_surface
from nodes.kernels.cell_lists import measure_shaft
from nodes.kernels.cell_rays import aim_camera
from tests.nodes.geometry.made_surfaces import ellipsoid, to_grid
from tests.nodes.kernels.oracle_rays import ray_cells

INDEX = np.eye(4)[:3].copy()


@njit
def measure(free, room, camera, middle, width):
    seer = aim_camera(free, INDEX, camera, np.ones(3), 0.0)
    way = (middle + 0.5) * 65536
    x, y, z = way[0] - seer.place[0], way[1] - seer.place[1], way[2] - seer.place[2]
    return measure_shaft(room, seer.place, x, y, z, width)


def test_free_parts_of_shafts_are_free_and_stopped_shafts_let_no_ray_through():
    free, rng = ellipsoid((22, 17, 14)), np.random.default_rng(0)
    i, j, k = np.indices(free.shape)
    free &= (i - 15) ** 2 + (j - 17) ** 2 + (k - 16) ** 2 > 30
    free &= abs(i - 31) > 1
    surface = find_surface(to_grid(free))
    places, cells = np.argwhere(free), np.argwhere(~free)
    kinds = []
    for _ in range(400):
        camera = places[rng.integers(len(places))] + rng.uniform(-0.4, 0.4, 3)
        middle, width = cells[rng.integers(len(cells))], int(rng.integers(0, 3))
        share = measure(surface.free, surface.room, camera, middle.astype(float), float(width))
        open_to = share if share >= 0 else -1 - share
        assert 0 <= open_to <= 1
        kinds.append((share < 0, open_to > 0.3))
        for _ in range(6):
            cell = np.clip(middle + rng.integers(-width, width + 1, 3), 0, np.array(free.shape) - 1)
            way = ray_cells(camera, cell)
            length = np.abs(cell - camera).sum()
            safe = [free[place] for place in way[: max(1, int(length * open_to - 1.5))]]
            assert all(safe)
            if share < 0:
                assert not all(free[place] for place in way[:-1])
    assert {True, False} == {stopped for stopped, _ in kinds} == {far for _, far in kinds}
