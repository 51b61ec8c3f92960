"""The map of a collapse: volumes by determinants, places by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodes.imaging.lung_deformation import (
    around_segment,
    coarsen,
    collapsed_from_healthy,
    find_anchor,
    find_hilum,
)

GRID = np.diag([2.0, 2.0, 5.0, 1.0])
GRID[:3, 3] = (-20, -90, -100)


def egg():
    """A left lung: an ellipsoid about (60, 0, 0) with half axes 50, 80, 90 mm."""
    index = np.stack(np.indices((80, 90, 40)), axis=-1)
    places = index @ GRID[:3, :3].T + GRID[:3, 3]
    return (((places - (60, 0, 0)) / (50, 80, 90)) ** 2).sum(axis=-1) < 1


@given(
    scale=st.floats(0.2, 1.2),
    flattening=st.floats(0.5, 3),
    direction=st.sampled_from(["posterior", "anterior", "medial"]),
)
def test_the_map_shrinks_volume_by_the_cube_of_its_scale_and_keeps_its_anchor(
    scale, flattening, direction
):
    anchor = np.array([40.0, 60.0, 10.0])
    transform = collapsed_from_healthy(anchor, scale, direction, flattening)
    assert np.linalg.det(transform[:3, :3]) == pytest.approx(scale**3)
    np.testing.assert_allclose(transform[:3, :3] @ anchor + transform[:3, 3], anchor, atol=1e-9)


def test_a_coarse_region_holds_the_volume_and_the_place_of_the_lung():
    lung = egg()
    region = coarsen(lung, GRID, 3.0)
    voxel = abs(np.linalg.det(region.patient_from_coarse[:3, :3]))
    assert region.share.sum() * voxel == pytest.approx(lung.sum() * 20.0, rel=1e-3)
    np.testing.assert_allclose(region.places_patient_mm.mean(axis=0), (60, 0, 0), atol=1)


def test_the_hilum_is_where_the_main_bronchus_meets_the_lung():
    z = np.arange(0, 150, 2.0)
    trachea = np.stack([0 * z, 0 * z, z], axis=1)
    x = np.arange(0, 40, 1.0)
    bronchus = np.stack([x, 0 * x, 0 * x - 5], axis=1)
    hilum = find_hilum(coarsen(egg(), GRID, 3.0), np.concatenate([trachea, bronchus]), 1)
    np.testing.assert_allclose(hilum, (25, 0, -5), atol=6)


def test_without_an_airway_the_hilum_is_the_inner_side():
    hilum = find_hilum(coarsen(egg(), GRID, 3.0), np.empty((0, 3)), 1)
    np.testing.assert_allclose(hilum, (14, 0, 0), atol=8)


@pytest.mark.parametrize(("direction", "sign"), [("posterior", 1), ("anterior", -1)])
def test_the_anchor_lies_on_the_wall_in_its_direction(direction, sign):
    hilum = np.array([60.0, 0.0, 0.0])
    anchor = find_anchor(coarsen(egg(), GRID, 3.0), hilum, direction)
    np.testing.assert_allclose(anchor, (60, sign * 80, 0), atol=4)


def test_distances_around_a_segment_are_those_of_dense_points_on_it():
    start, end = np.array([10.0, -20, 0]), np.array([40.0, 10, 30])
    window, found = around_segment(GRID, (80, 90, 40), (start, end), 12.0)
    dense = start + np.linspace(0, 1, 400)[:, None] * (end - start)
    index = np.stack(np.indices((80, 90, 40)), axis=-1)
    places = (index @ GRID[:3, :3].T + GRID[:3, 3])[window].reshape(-1, 3)
    true = np.linalg.norm(places[:, None] - dense[None, ::4], axis=2).min(axis=1)
    np.testing.assert_allclose(found.ravel(), true, atol=0.4)
    outside = np.ones((80, 90, 40), bool)
    outside[window] = False
    far = (index @ GRID[:3, :3].T + GRID[:3, 3])[outside][::50]
    assert np.linalg.norm(far[:, None] - dense[None, ::20], axis=2).min() > 11.5
