"""Skin points and directions about the normal, against a ball's and a cone's formulas."""

import numpy as np
import pytest

from nodes.environment.needle_starts import cone_directions, skin_points


@pytest.mark.parametrize("apart", [2.0, 4.0])
def test_points_of_a_balls_skin_lie_on_it_face_inward_and_are_evenly_many(apart):
    spacing = np.array([0.9, 1.3, 1.1])
    middle = np.array([34.0, 31.0, 36.0])
    index = np.stack(np.indices((76, 48, 66)), axis=-1) * spacing
    body = np.linalg.norm(index - middle, axis=-1) < 25
    body[38:40, 24:26, 30:34] = False  # a hole inside is not skin
    points, inward = skin_points(body, spacing, apart)
    away = points - middle
    # smoothing of variance v draws a sphere in by v / radius; cells add the variance of a box
    radius = 25 - apart**2 * (1 + 1 / 12) / 25
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), radius, atol=0.4)
    np.testing.assert_allclose(np.linalg.norm(inward, axis=1), 1, rtol=1e-6)
    cosine = -np.einsum("ni,ni->n", away, inward) / np.linalg.norm(away, axis=1)
    assert cosine.min() > np.cos(np.radians(8))
    per_cell = len(points) * apart**2 / (4 * np.pi * 25**2)
    assert 0.8 < per_cell < 2


def test_where_the_image_cuts_the_body_there_is_no_skin_and_no_rounded_edge():
    body = np.zeros((30, 40, 20), bool)
    body[:, 12:] = True
    points, inward = skin_points(body, np.array([1.0, 1.0, 2.0]), 4.0)
    np.testing.assert_allclose(points[:, 1], 11.5, atol=0.5)
    np.testing.assert_allclose(inward, np.tile([0, 1, 0], (len(points), 1)), atol=1e-6)
    assert points[:, [0, 2]].min() > -1.01 and (points[:, [0, 2]].max(axis=0) > [25, 33]).all()


def test_a_body_smaller_than_a_cell_has_no_skin():
    body = np.zeros((9, 9, 9), bool)
    body[4, 4, 4] = True
    points, inward = skin_points(body, np.ones(3), 5.0)
    assert points.shape == inward.shape == (0, 3)


def test_directions_fill_the_cone_about_each_normal():
    normals = np.random.default_rng(0).normal(size=(20, 3))
    normals = np.concatenate([normals, np.eye(3), -np.eye(3)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    directions = cone_directions(normals, 30.0, 10.0)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=2), 1)
    np.testing.assert_allclose(directions[:, 0], normals, atol=1e-12)
    tilts = np.degrees(np.arccos(np.clip(np.einsum("ndx,nx->nd", directions, normals), -1, 1)))
    assert set(np.rint(tilts.ravel())) == {0, 10, 20, 30}
    # every direction within the cone has one within about a step of it
    chance = np.random.default_rng(1).normal(size=(4000, 3))
    chance /= np.linalg.norm(chance, axis=1, keepdims=True)
    for normal, fan in zip(normals, directions, strict=True):
        inside = chance[chance @ normal > np.cos(np.radians(30))]
        nearest = np.degrees(np.arccos(np.clip((inside @ fan.T).max(axis=1), -1, 1)))
        assert nearest.max() < 10


def test_no_tilt_leaves_the_normal_alone():
    np.testing.assert_array_equal(cone_directions(np.eye(3), 0.0, 10.0)[:, 0], np.eye(3))
    assert cone_directions(np.eye(3), 9.0, 10.0).shape == (3, 1, 3)
