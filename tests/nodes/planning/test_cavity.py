"""Grids for collision checking: what they hold, and which are refused."""

from dataclasses import replace

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.planning.cavity import make_cavity, make_wall
from tests.nodes.kernels.made_spaces import MADE, grid_of, turned_affine


def made(seed=0):
    rng = np.random.default_rng(seed)
    free = rng.random((5, 6, 7)) < 0.7
    return free, *grid_of(free, turned_affine(rng, [1.0, 0.7, 1.9]))


def test_room_is_no_more_than_the_distance_and_little_less():
    free, grid, field = made()
    cavity = make_cavity(grid, field)
    assert np.array_equal(cavity.free, free)
    assert np.all(cavity.room[free] <= field.voxels[free])
    assert np.allclose(cavity.room[free], field.voxels[free], rtol=1e-5)
    assert not cavity.room[~free].any()


def test_a_wall_has_room_up_to_the_nearest_box_of_its_labels():
    free, grid, _ = made(1)
    wall = make_wall(replace(grid, voxels=(~free).astype(np.uint8), names=("bone",)), ("bone",))
    spacing = np.linalg.norm(grid.patient_from_index[:3, :3], axis=0)
    bones = np.argwhere(~free) * spacing
    for cell in np.argwhere(free):
        away = np.maximum(abs(cell * spacing - bones) - spacing / 2, 0)
        exact = np.linalg.norm(away, axis=1).min()
        assert wall.room[tuple(cell)] == pytest.approx(exact, rel=1e-5)


def test_distances_of_another_grid_are_refused():
    _, grid, field = made()
    with pytest.raises(BadInput, match="occupancy grid"):
        make_cavity(grid, replace(field, patient_from_index=np.eye(4)))


def test_slanted_axes_are_refused():
    _, grid, _ = made()
    slanted = np.eye(4)
    slanted[0, 1] = 0.1
    with pytest.raises(BadInput, match="orthogonal"):
        make_wall(replace(grid, patient_from_index=slanted, names=("bone",)), ("bone",))


def test_a_label_that_is_not_there_is_refused_by_name():
    grid = LabelMap(np.zeros((2, 2, 2), np.uint8), np.eye(4), ("body",), MADE)
    with pytest.raises(BadInput, match="bone"):
        make_wall(grid, ("bone",))
    assert make_wall(grid, ()).free.size == 0
