"""Volumes and parts of labels."""

import numpy as np
import pytest

from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from nodes.imaging.measure_labels import measure_labels


def test_volumes_in_ml_and_parts_over_faces():
    voxels = np.zeros((9, 9, 9), np.uint8)
    voxels[:2, :2, :2] = 1
    voxels[2, 2, 2] = 1  # touches over a corner only
    voxels[5:, 5:, 5:] = 2
    matrix = np.array([[0, -2.0, 0, 1], [3, 0, 0, 2], [0, 0, 5, 3], [0, 0, 0, 1]])
    table = measure_labels(LabelMap(voxels, matrix, ("lung", "bone", "none"), Origin("test")))
    assert list(table.columns) == ["label", "volume_ml", "parts"]
    assert list(table.label) == ["lung", "bone", "none"]
    assert list(table.volume_ml) == pytest.approx([9 * 0.03, 64 * 0.03, 0])
    assert list(table.parts) == [2, 1, 0]


def test_the_volume_of_an_ellipsoid_is_that_of_its_formula():
    radii = np.array([20.0, 12.0, 15.0])
    spacing = np.array([0.7, 0.9, 1.3])
    index = np.stack(np.indices((70, 40, 40)), axis=-1) - [34.6, 19.7, 19.1]
    inside = ((index * spacing / radii) ** 2).sum(axis=-1) < 1
    table = measure_labels(
        LabelMap(inside.astype(np.uint8), np.diag([*spacing, 1.0]), ("ball",), Origin("test"))
    )
    assert table.volume_ml[0] == pytest.approx(4 / 3 * np.pi * radii.prod() / 1000, rel=0.01)
