"""Points are apart, cover their surfaces and face outward, by brute force."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.environment.parameters import SamplePointCloudParameters
from nodes.environment.sample_point_cloud import sample_point_cloud
from nodes.errors import BadInput
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.origin import Origin


def parameters(spacing=2.0, seed=0):
    return SamplePointCloudParameters(spacing_mm=spacing, seed=seed)


def mesh(solid):
    return Mesh(np.array(solid.vertices, np.float32), np.array(solid.faces, np.int32))


def ball_in_box():
    box = trimesh.creation.box((20, 30, 40))  # triangles much larger than the spacing
    ball = trimesh.creation.icosphere(subdivisions=4, radius=8.0)  # and much smaller
    return Surfaces((("box", mesh(box)), ("ball", mesh(ball))), Origin("x", True)), (box, ball)


@pytest.mark.parametrize("spacing", [1.0, 2.5, 9.0])
def test_points_of_a_surface_are_apart_and_every_place_has_one_near(spacing):
    surfaces, solids = ball_in_box()
    cloud = sample_point_cloud(surfaces, parameters(spacing))
    for label, solid in enumerate(solids, start=1):
        points = cloud.points_patient_mm[cloud.labels == label].astype(float)
        apart = np.linalg.norm(points[:, None] - points, axis=2) + np.diag([np.inf] * len(points))
        assert apart.min() >= spacing * (1 - 1e-5)
        places = trimesh.sample.sample_surface(solid, 2000, seed=1)[0]
        places = np.concatenate([places, solid.vertices])
        nearest = np.linalg.norm(places[:, None] - points, axis=2).min(axis=1)
        assert nearest.max() <= 1.25 * spacing


def test_points_lie_on_their_surface_and_normals_point_outward():
    surfaces, (box, _) = ball_in_box()
    cloud = sample_point_cloud(surfaces, parameters())
    places, normals = cloud.points_patient_mm, cloud.normals
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=1e-5)
    on_box, on_ball = cloud.labels == 1, cloud.labels == 2
    depth = (abs(places[on_box]) - box.extents / 2).max(axis=1)
    np.testing.assert_allclose(depth, 0, atol=1e-4)
    assert (np.einsum("ni,ni->n", places[on_box], normals[on_box]) > 0).all()
    radial = places[on_ball] / np.linalg.norm(places[on_ball], axis=1, keepdims=True)
    assert np.einsum("ni,ni->n", radial, normals[on_ball]).min() > 0.98
    assert cloud.names == ("box", "ball")
    assert cloud.origin.simulated and "2 mm or more apart" in cloud.origin.notices[0]


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.5, 20))
def test_any_triangle_is_covered(seed, spacing):
    corners = np.random.default_rng(seed).normal(size=(3, 3)).astype(np.float32) * 10
    surfaces = Surfaces((("t", Mesh(corners, np.array([[0, 1, 2]], np.int32))),), Origin("x"))
    cloud = sample_point_cloud(surfaces, parameters(spacing))
    weights = np.random.default_rng(seed).dirichlet(np.ones(3), 500)
    places = np.concatenate([weights @ corners, corners])
    nearest = np.linalg.norm(places[:, None] - cloud.points_patient_mm, axis=2).min(axis=1)
    assert nearest.max() <= 1.25 * spacing


def test_a_seed_gives_the_same_points_and_another_seed_others():
    surfaces, _ = ball_in_box()
    one, same, other = (sample_point_cloud(surfaces, parameters(seed=s)) for s in (0, 0, 1))
    np.testing.assert_array_equal(one.points_patient_mm, same.points_patient_mm)
    assert not np.array_equal(one.points_patient_mm[:50], other.points_patient_mm[:50])


def test_flat_triangles_give_no_points_and_nothing_at_all_is_refused():
    corners = np.array([[0, 0, 0], [1, 1, 1], [2, 2, 2]], np.float32)
    flat = Surfaces((("t", Mesh(corners, np.array([[0, 1, 2]], np.int32))),), Origin("x"))
    for surfaces in (flat, Surfaces((), Origin("x"))):
        with pytest.raises(BadInput, match="without a triangle"):
            sample_point_cloud(surfaces, parameters())
