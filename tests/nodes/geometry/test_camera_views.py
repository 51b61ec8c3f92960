"""Depth of planes and balls against closed forms."""

import numpy as np
import pytest

from nodes.geometry.camera_views import pixel_rays, render_depth, soften_distance
from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin

CELL = 0.5
ORIGIN = Origin("a made field", True)


def field(value, shape=(44, 48, 40)):
    """Return a field of a function of places, mm, on a mirrored and shifted grid."""
    patient_from_index = np.diag([-CELL, CELL, CELL, 1.0])
    patient_from_index[:3, 3] = 11.0, -12.0, -10.0
    index = np.stack(np.indices(shape), axis=-1)
    places = index @ patient_from_index[:3, :3].T + patient_from_index[:3, 3]
    return Volume(value(places).astype(np.float32), patient_from_index, "mm", ORIGIN)


def turned(place):
    """Return a camera at a place that looks along (2, 1, 2) / 3."""
    forward = np.array([2.0, 1.0, 2.0]) / 3
    right = np.array([1.0, 0.0, -1.0]) / np.sqrt(2)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    pose[:3, 3] = place
    return pose


@pytest.mark.parametrize("angle", [60.0, 120.0])
def test_depth_normals_and_points_of_a_ball_are_those_of_its_formula(angle):
    radius, place = 8.0, np.array([1.0, -2.0, 0.5])
    ball = field(lambda places: radius - np.linalg.norm(places, axis=-1))
    pose = turned(place)
    depth, normals, points = render_depth(ball, pose, angle, 41)
    rays = pixel_rays(41, angle) @ pose[:3, :3].T
    along = rays @ place
    exact = -along + np.sqrt(along**2 - place @ place + radius**2)
    middle = (2 * np.arange(41) + 1) / 41 - 1
    inside = np.hypot(*np.meshgrid(middle, middle)) <= 1
    np.testing.assert_array_equal(np.isnan(depth), ~inside)
    np.testing.assert_allclose(depth[inside], exact[inside], atol=0.03)
    np.testing.assert_allclose(points[inside], (place + exact[..., None] * rays)[inside], atol=0.03)
    np.testing.assert_allclose(normals[inside], -points[inside] / radius, atol=0.02)


def test_a_plane_is_exact_to_rounding():
    wall = field(lambda places: 3.0 - places[..., 0])
    pose = turned(np.array([0.25, 0.1, -0.3]))
    depth, normals, _ = render_depth(wall, pose, 50.0, 32)
    rays = pixel_rays(32, 50.0) @ pose[:3, :3].T
    seen = ~np.isnan(depth)
    np.testing.assert_allclose(depth[seen], (2.75 / rays[..., 0])[seen], atol=2e-4)
    np.testing.assert_allclose(normals[seen], np.tile([-1.0, 0, 0], (seen.sum(), 1)), atol=1e-5)


def test_the_middle_looks_forward_and_the_rim_at_half_the_field_of_view():
    rays = pixel_rays(101, 110.0)
    np.testing.assert_allclose(rays[50, 50], [0, 0, 1], atol=1e-12)
    right, down = rays[50, 100], rays[100, 50]
    assert right[0] > 0 and abs(right[1]) < 1e-12 and down[1] > 0 and abs(down[0]) < 1e-12
    assert np.degrees(np.arccos(right[2])) == pytest.approx(55 * 100 / 101)


def test_cameras_that_are_not_in_free_space_see_nothing():
    wall = field(lambda places: 6.0 - places[..., 0])
    for place in ([7.0, 0, 0], [400.0, 0, 0]):
        depth, _, _ = render_depth(wall, turned(np.array(place)), 90.0, 8)
        assert np.isnan(depth).all()


def test_softening_keeps_planes_and_evens_steps():
    wall = field(lambda places: 6.0 - places[..., 0])
    rough = field(lambda places: 6.0 - places[..., 0] + 0.25 * np.sign(np.sin(9 * places[..., 1])))
    inner = (slice(8, -8),) * 3
    soft = soften_distance(wall, 0.7)
    np.testing.assert_allclose(soft.voxels[inner], wall.voxels[inner], atol=1e-4)
    even = soften_distance(rough, 0.7).voxels - wall.voxels
    assert np.abs(even[inner]).max() < 0.1 and soft.origin.notices
