"""Surfaces are closed, wind outward and hold the volume, as trimesh sees them."""

import numpy as np
import open3d
import pytest
import trimesh
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nodes.environment.build_surfaces import build_surfaces
from nodes.environment.parameters import BuildSurfacesParameters
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin


def parameters(size=1.0, steps=5, triangles=2000, **changed):
    values = {"outer_labels": ("body",), "voxel_size_mm": size, "voxel_size_mm_by_label": {},
              "smoothing_steps": steps, "volume_tolerance": 0.03, "triangles": triangles,
              "triangles_by_label": {}}  # fmt: skip
    return BuildSurfacesParameters(**{**values, **changed})


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


def label_volume(labels, name):
    mask = labels.voxels > 0 if name == "body" else labels.mask(name)
    return mask.sum() * abs(np.linalg.det(labels.patient_from_index[:3, :3]))


def thin_plate():
    """A plate of 2 mm, thinner than most cells, with a block of 10 mm at its end."""
    voxels = np.zeros((50, 40, 40))
    voxels[5:40, 5:35, 18:20] = 1
    voxels[35:45, 15:25, 15:25] = 1
    return label_map(voxels, names=("bone",))


@pytest.mark.parametrize("size", [1.0, 1.7])
def test_surfaces_enclose_the_volume_of_their_label(size):
    for labels in (two_balls(), thin_plate()):
        surfaces = build_surfaces(labels, parameters(size))
        for name, mesh in surfaces.meshes:
            assert as_trimesh(mesh).volume == pytest.approx(label_volume(labels, name), rel=1e-3)
        assert not any("encloses" in notice for notice in surfaces.origin.notices)


def test_a_surface_that_loses_much_is_not_blown_up_but_says_what_it_lacks():
    labels = thin_plate()
    surfaces = build_surfaces(labels, parameters(size=5.0))
    volume = as_trimesh(surfaces.meshes[0][1]).volume
    assert volume < 0.9 * label_volume(labels, "bone")
    assert any("the surface of bone encloses" in notice for notice in surfaces.origin.notices)


def test_each_label_has_its_own_cells_and_triangles_and_misses_are_said():
    chosen = parameters(triangles=800, triangles_by_label={"bone": 300},
                        voxel_size_mm_by_label={"bone": 6.0})  # fmt: skip
    surfaces = build_surfaces(two_balls(), chosen)
    (_, body), (_, bone) = surfaces.meshes
    assert 0.99 * 800 - 2 <= len(body.triangles) <= 800
    assert len(bone.triangles) < 290
    (notice,) = surfaces.origin.notices
    assert notice.startswith(f"the surface of bone has {len(bone.triangles)} triangles, not 300")


def test_only_outer_labels_bound_what_lies_within_them():
    labels = two_balls()
    (_, mesh), _ = build_surfaces(labels, parameters(outer_labels=())).meshes
    hollow = as_trimesh(mesh)
    assert hollow.volume == pytest.approx(labels.mask("body").sum() * 2.0, rel=1e-3)
    assert hollow.body_count == 2


def face_centres(mask, matrix):
    """Centres of all faces between a mask and the rest, mm."""
    centres = []
    padded = np.pad(mask, 1).astype(int)
    for axis in range(3):
        places = np.argwhere(np.diff(padded, axis=axis)).astype(float) - 1
        places[:, axis] += 0.5
        centres.append(places)
    return np.concatenate(centres) @ matrix[:3, :3].T + matrix[:3, 3]


def test_no_place_of_surface_or_label_is_further_than_a_cell_from_the_other():
    labels = two_balls()
    for name, mesh in build_surfaces(labels, parameters(size=1.5)).meshes:
        mask = labels.voxels > 0 if name == "body" else labels.mask(name)
        faces = face_centres(mask, labels.patient_from_index)
        closed = as_trimesh(mesh)
        places = trimesh.sample.sample_surface(closed, 1500, seed=0)[0]
        # a place within a face is up to half of its diagonal from the face's centre
        to_label = np.sqrt(((places[:, None] - faces) ** 2).sum(axis=2).min(axis=1))
        assert to_label.max() <= 1.5 + np.sqrt(5) / 2
        scene = open3d.t.geometry.RaycastingScene()
        scene.add_triangles(mesh.vertices_patient_mm.copy(), mesh.triangles.astype(np.uint32))
        assert scene.compute_distance(faces.astype(np.float32)).numpy().max() <= 1.5


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
    assert closed.volume == pytest.approx(9**3, rel=1e-3)
    # its sides move by 0.03 mm to make good for the edges and corners that marching cubes cuts off
    np.testing.assert_allclose(closed.bounds, [[-0.53] * 3, [8.53] * 3], atol=0.01)


def test_empty_and_tiny_labels_have_no_surface_and_are_named():
    voxels = np.zeros((12, 12, 12))
    voxels[2:10, 2:10, 2:10] = 1
    surfaces = build_surfaces(label_map(voxels), parameters())
    assert [name for name, _ in surfaces.meshes] == ["body"]
    assert "bone is empty or smaller than a cell and has no surface" in surfaces.origin.notices
    assert surfaces.origin.simulated
    with pytest.raises(BadInput, match="without labelled voxels"):
        build_surfaces(label_map(np.zeros((5, 5, 5))), parameters())


def test_the_same_labels_give_the_same_surfaces():
    one, same = (build_surfaces(two_balls(), parameters()) for _ in range(2))
    for (_, left), (_, right) in zip(one.meshes, same.meshes, strict=True):
        np.testing.assert_array_equal(left.vertices_patient_mm, right.vertices_patient_mm)
        np.testing.assert_array_equal(left.triangles, right.triangles)
