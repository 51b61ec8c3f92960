"""Resampling to the patient's axes: linear fields stay what they are, wherever the voxels lay."""

import numpy as np
import pytest

from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin
from nodes.imaging.working_grid import to_working_grid


def oblique(spacing) -> np.ndarray:
    c, s = np.cos(0.3), np.sin(0.3)
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([[0, -c, s], [1, 0, 0], [0, -s, -c]]) * spacing
    matrix[:3, 3] = 5, -40, 12
    return matrix


@pytest.mark.parametrize("spacing", [(3.0, 2.0, 2.5), (0.9, 1.1, 2.0)])
def test_a_linear_field_is_the_same_at_the_same_place(spacing):
    matrix = oblique(spacing)
    index = np.stack([*np.indices((40, 45, 30)), np.ones((40, 45, 30))], -1)
    places = index @ matrix.T
    field = 3 + places[..., :3] @ [0.5, -0.2, 0.3]
    voxels, grid = to_working_grid(
        Volume(field.astype(np.float32), matrix, "intensity", Origin("ramp")), 2.0, -999.0
    )
    np.testing.assert_array_equal(grid[:3, :3], np.diag([2.0, 2, 2]))
    points = np.stack(np.indices(voxels.shape), -1) * 2.0 + grid[:3, 3]
    back = (points - matrix[:3, 3]) @ np.linalg.inv(matrix[:3, :3]).T
    inner = ((back > 4) & (back < np.array([35, 40, 25]))).all(-1)
    beyond = ((back < -1) | (back > np.array([40, 45, 30]))).any(-1)
    assert inner.sum() > 1000 and beyond.any()
    np.testing.assert_allclose(voxels[inner], (3 + points @ [0.5, -0.2, 0.3])[inner], atol=0.02)
    assert (voxels[beyond] == -999).all()


def test_every_voxel_of_the_volume_is_covered():
    matrix = oblique((1.0, 1.0, 1.0))
    volume = Volume(np.zeros((10, 20, 30), np.float32), matrix, "intensity", Origin("zeros"))
    voxels, grid = to_working_grid(volume, 1.5, 0.0)
    corners = np.array(list(np.ndindex(2, 2, 2))) * [9, 19, 29]
    places = (corners @ matrix[:3, :3].T + matrix[:3, 3] - grid[:3, 3]) / 1.5
    assert places.min() > -0.51 and (places.max(axis=0) < np.array(voxels.shape) - 0.49).all()


def test_finer_voxels_are_averaged_so_noise_falls():
    noise = np.random.default_rng(3).normal(size=(80, 80, 80)).astype(np.float32)
    volume = Volume(noise, np.diag([0.5, 0.5, 0.5, 1]), "intensity", Origin("noise"))
    voxels, _ = to_working_grid(volume, 2.0, 0.0)
    assert voxels[2:-2, 2:-2, 2:-2].std() < 0.3
