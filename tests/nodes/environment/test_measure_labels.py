"""Volumes, parts and areas of labels and of groups of them."""

import numpy as np
import pytest
import trimesh

from nodes.environment.measure_labels import measure_labels
from nodes.environment.parameters import MeasureLabelsParameters
from nodes.geometry.grids import LabelMap
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.origin import Origin

LUNGS = MeasureLabelsParameters(groups={"lungs": ("left", "right"), "brain": ("a", "b")})
NO_SURFACES = Surfaces((), Origin("test"))


def test_volumes_in_ml_and_parts_over_faces():
    voxels = np.zeros((9, 9, 9), np.uint8)
    voxels[:2, :2, :2] = 1
    voxels[2, 2, 2] = 1  # touches over a corner only
    voxels[5:, 5:, 5:] = 2
    matrix = np.array([[0, -2.0, 0, 1], [3, 0, 0, 2], [0, 0, 5, 3], [0, 0, 0, 1]])
    label_map = LabelMap(voxels, matrix, ("left", "right", "none"), Origin("test"))
    table = measure_labels(label_map, NO_SURFACES, LUNGS)
    assert list(table.columns) == [
        "label", "volume_ml", "surface_area_cm2", "parts", "largest_part_share",
    ]  # fmt: skip
    assert list(table.label) == ["left", "right", "none", "lungs"]
    assert list(table.volume_ml) == pytest.approx([9 * 0.03, 64 * 0.03, 0, 73 * 0.03])
    assert list(table.parts) == [2, 1, 0, 3]
    assert list(table.largest_part_share) == pytest.approx([8 / 9, 1, np.nan, 64 / 73], nan_ok=True)
    assert table.surface_area_cm2.isna().all()


def test_a_group_is_measured_over_the_labels_that_are_there_and_hides_no_label():
    voxels = np.ones((4, 4, 4), np.uint8)
    for names, rows in ((("left",), ["left", "lungs"]), (("lungs",), ["lungs"])):
        label_map = LabelMap(voxels, np.eye(4), names, Origin("test"))
        table = measure_labels(label_map, NO_SURFACES, LUNGS)
        assert list(table.label) == rows


def test_areas_are_those_of_trimesh():
    ball = trimesh.creation.icosphere(subdivisions=3, radius=20.0)
    mesh = Mesh(np.array(ball.vertices, np.float32), np.array(ball.faces, np.int32))
    label_map = LabelMap(np.ones((3, 3, 3), np.uint8), np.eye(4), ("ball",), Origin("test"))
    table = measure_labels(label_map, Surfaces((("ball", mesh),), Origin("test")), LUNGS)
    assert table.surface_area_cm2[0] == pytest.approx(ball.area / 100, rel=1e-6)


def test_the_volume_of_an_ellipsoid_is_that_of_its_formula():
    radii = np.array([20.0, 12.0, 15.0])
    spacing = np.array([0.7, 0.9, 1.3])
    index = np.stack(np.indices((70, 40, 40)), axis=-1) - [34.6, 19.7, 19.1]
    inside = ((index * spacing / radii) ** 2).sum(axis=-1) < 1
    label_map = LabelMap(
        inside.astype(np.uint8), np.diag([*spacing, 1.0]), ("ball",), Origin("test")
    )
    table = measure_labels(label_map, NO_SURFACES, LUNGS)
    assert table.volume_ml[0] == pytest.approx(4 / 3 * np.pi * radii.prod() / 1000, rel=0.01)
