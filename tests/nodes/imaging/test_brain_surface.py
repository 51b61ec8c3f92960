"""The growing surface on balls, whose brain and volume are known."""

import numpy as np
import pytest
from scipy import ndimage

from nodes.imaging.brain_surface import Levels, fill_surface, grow_brain_surface

LEVELS = Levels(0.0, 20.0, 100.0, 160.0)


def ball(shape, centre, radius) -> np.ndarray:
    return np.linalg.norm(np.stack(np.indices(shape), -1) - centre, axis=-1) < radius


def layered_head(bone: float = 6.0) -> np.ndarray:
    """Brain of radius 30 voxels, dark bone, bright scalp, air."""
    shape, middle = (96, 96, 96), np.array([47.0, 49, 48])
    voxels = np.zeros(shape, np.float32)
    voxels[ball(shape, middle, 30 + bone + 6)] = 160
    voxels[ball(shape, middle, 30 + bone)] = 10
    voxels[ball(shape, middle, 30)] = 100
    return voxels


@pytest.mark.parametrize("start", [(94.0, 98.0, 96.0), (106.0, 90.0, 102.0)])
def test_the_surface_comes_to_lie_on_the_brain_wherever_it_starts(start):
    vertices, _ = grow_brain_surface(layered_head(), 2.0, np.array(start), 70.0, LEVELS, 0.5, 400)
    radii = np.linalg.norm(vertices - [94, 98, 96], axis=1)
    assert abs(np.median(radii) - 60) < 2 and radii.std() < 1.5


def test_triangles_stay_wound_outward():
    vertices, triangles = grow_brain_surface(
        layered_head(), 2.0, np.array([94.0, 98, 96]), 70.0, LEVELS, 0.5, 300
    )
    a, b, c = np.moveaxis(vertices[triangles] - [94, 98, 96], 1, 0)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(4 / 3 * np.pi * 60**3, rel=0.06)


def tetrahedron(size: float) -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([[0.0, 0, 0], [size, 0, 0], [0, size, 0], [0, 0, size]]) + 3
    return corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def test_a_filled_surface_holds_all_voxels_inside_and_none_a_voxel_outside():
    corners, triangles = tetrahedron(60.0)
    filled = fill_surface(corners, triangles, (40, 40, 40), 2.0)
    p = np.stack(np.indices((40, 40, 40)), -1) * 2.0 - 3
    outside = np.maximum(-p.min(axis=-1), (p.sum(axis=-1) - 60) / np.sqrt(3))
    assert filled[outside <= 0].all()
    assert not filled[outside > 2.0].any()


def test_a_surface_that_leaves_the_image_fills_what_is_in_it():
    corners, triangles = tetrahedron(60.0)
    whole = fill_surface(corners + 20, triangles, (60, 60, 60), 2.0)
    cut = fill_surface(corners + 20, triangles, (60, 60, 25), 2.0)
    agreement = (cut == whole[:, :, :25]).mean()
    assert agreement > 0.99


def test_one_filled_surface_is_one_part_without_holes():
    vertices, triangles = grow_brain_surface(
        layered_head(), 2.0, np.array([94.0, 98, 96]), 70.0, LEVELS, 0.5, 200
    )
    filled = fill_surface(vertices, triangles, (96, 96, 96), 2.0)
    assert ndimage.label(filled)[1] == 1 == ndimage.label(~filled)[1]
