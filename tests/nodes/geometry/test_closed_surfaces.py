"""Volumes, areas and normals of closed surfaces, as trimesh has them."""

import numpy as np
import pytest
import trimesh

from nodes.geometry.closed_surfaces import enclosed_volume_mm3, surface_area_mm2, triangle_normals
from nodes.geometry.meshes import Mesh


def solids():
    turn = trimesh.transformations.rotation_matrix(0.7, (1, 2, 3))
    return [
        trimesh.creation.icosphere(subdivisions=3, radius=20.0),
        trimesh.creation.torus(20, 6).apply_transform(turn),
        trimesh.creation.box((1, 2, 3)).apply_translation((500, -800, 1200)),
    ]


@pytest.mark.parametrize("solid", solids())
def test_volume_area_and_normals_are_those_of_trimesh(solid):
    mesh = Mesh(np.array(solid.vertices, np.float32), np.array(solid.faces, np.int32))
    assert enclosed_volume_mm3(mesh) == pytest.approx(solid.volume, rel=1e-3)
    assert surface_area_mm2(mesh) == pytest.approx(solid.area, rel=1e-4)
    normals = triangle_normals(solid.vertices, mesh.triangles)
    np.testing.assert_allclose(
        normals, solid.face_normals * solid.area_faces[:, None], atol=1e-6 * solid.area
    )


def test_a_triangle_without_area_has_no_normal():
    corners = np.array([[0.0, 0, 0], [1, 1, 1], [2, 2, 2]])
    assert not triangle_normals(corners, np.array([[0, 1, 2]])).any()
