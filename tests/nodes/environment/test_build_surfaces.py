"""Surfaces are closed, wind outward and hold the volume, as trimesh sees them."""

import numpy as np
import pytest
import trimesh
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nodes.environment.build_surfaces import build_surfaces, enclosed_volume_mm3
from nodes.environment.parameters import BuildSurfacesParameters
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin


def parameters(size=1.0, steps=5, triangles=2000):
    return BuildSurfacesParameters(
        voxel_size_mm=size, smoothing_steps=steps, triangles=triangles, volume_tolerance=0.03
    )


def label_map(voxels, matrix=None, names=("body", "bone")):
    matrix = np.eye(4) if matrix is None else matrix
    return LabelMap(np.asarray(voxels, np.uint8), matrix, names, Origin("test", simulated=True))


def as_trimesh(mesh):
    return trimesh.Trimesh(mesh.vertices_patient_mm, mesh.triangles, process=False)


def two_balls(matrix=None):
    """A bone ball of radius 12 within a body ball of radius 24, mm, with a spacing of 1, 1, 2."""
    index = np.stack(np.indices((60, 60, 30)), axis=-1) - [29.5, 29.5, 14.5]
    squared = ((index * [1, 1, 2]) ** 2).sum(axis=-1)
    voxels = np.where(squared < 12**2, 2, np.where(squared < 24**2, 1, 0))
    return label_map(voxels, np.diag([1.0, 1.0, 2.0, 1.0]) if matrix is None else matrix)


def test_enclosed_volume_is_that_of_trimesh_and_a_surface_that_loses_some_says_so():
    surfaces = build_surfaces(two_balls(), parameters())
    for _, mesh in surfaces.meshes:
        assert enclosed_volume_mm3(mesh) == pytest.approx(as_trimesh(mesh).volume, rel=1e-4)
    assert not any("encloses" in notice for notice in surfaces.origin.notices)
    thin = np.zeros((40, 40, 40))
    thin[5:35, 5:35, 18:20] = 1
    notices = build_surfaces(label_map(thin), parameters(size=1.5)).origin.notices
    assert any("the surface of body encloses" in notice for notice in notices)


MIRRORED = np.array([[0, 0, 2.0, -30], [0, 1.0, 0, 40], [1.0, 0, 0, 5], [0, 0, 0, 1]])


@pytest.mark.parametrize("matrix", [None, MIRRORED])
def test_balls_are_closed_outward_and_of_their_volume_on_any_grid(matrix):
    surfaces = build_surfaces(two_balls(matrix), parameters())
    assert [name for name, _ in surfaces.meshes] == ["body", "bone"]
    middle = (np.diag([1, 1, 2, 1]) if matrix is None else matrix) @ [29.5, 29.5, 14.5, 1]
    for (_, mesh), radius in zip(surfaces.meshes, (24, 12), strict=True):
        closed = as_trimesh(mesh)
        assert closed.is_watertight and closed.is_winding_consistent
        assert closed.volume == pytest.approx(4 / 3 * np.pi * radius**3, rel=0.03)
        distances = np.linalg.norm(mesh.vertices_patient_mm - middle[:3], axis=1)
        np.testing.assert_allclose(distances, radius, atol=1.0)
        assert len(mesh.triangles) <= 2000


@pytest.mark.parametrize(("triangles", "least"), [(2000, 0.998), (50_000, 1.0)])
def test_normals_point_away_from_the_middle(triangles, least):
    """Collapsing edges folds a triangle in a thousand over; undecimated, none is."""
    (_, mesh), _ = build_surfaces(two_balls(), parameters(triangles=triangles)).meshes
    closed = as_trimesh(mesh)
    outward = closed.triangles_center - [29.5, 29.5, 29.0]
    assert np.mean(np.einsum("ni,ni->n", closed.face_normals, outward) > 0) >= least


@settings(max_examples=25, deadline=None)
@given(
    arrays(np.uint8, st.tuples(*[st.integers(1, 6)] * 3), elements=st.integers(0, 2)),
    st.sampled_from([0.6, 1.0, 1.3]),
    st.integers(0, 3),
)
def test_any_labels_give_closed_outward_surfaces(voxels, size, steps):
    try:
        surfaces = build_surfaces(label_map(voxels), parameters(size, steps, triangles=100))
    except BadInput:
        assume(False)
    for _, mesh in surfaces.meshes:
        closed = as_trimesh(mesh)
        assert closed.is_watertight and closed.is_winding_consistent
        assert closed.volume > 0


def test_a_label_cut_by_the_images_edge_is_closed_there():
    surfaces = build_surfaces(label_map(np.ones((9, 9, 9)), names=("body",)), parameters(steps=0))
    closed = as_trimesh(surfaces.meshes[0][1])
    assert closed.is_watertight
    assert closed.volume == pytest.approx(9**3, rel=0.05)
    np.testing.assert_allclose(closed.bounds, [[-0.5] * 3, [8.5] * 3], atol=0.01)


def test_empty_and_tiny_labels_have_no_surface_and_are_named():
    voxels = np.zeros((12, 12, 12))
    voxels[2:10, 2:10, 2:10] = 1
    surfaces = build_surfaces(label_map(voxels), parameters())
    assert [name for name, _ in surfaces.meshes] == ["body"]
    assert surfaces.origin.notices == ("bone is empty or smaller than a cell and has no surface",)
    assert surfaces.origin.simulated
    with pytest.raises(BadInput, match="without labelled voxels"):
        build_surfaces(label_map(np.zeros((5, 5, 5))), parameters())


def test_the_same_labels_give_the_same_surfaces():
    one, same = (build_surfaces(two_balls(), parameters()) for _ in range(2))
    for (_, left), (_, right) in zip(one.meshes, same.meshes, strict=True):
        np.testing.assert_array_equal(left.vertices_patient_mm, right.vertices_patient_mm)
        np.testing.assert_array_equal(left.triangles, right.triangles)
