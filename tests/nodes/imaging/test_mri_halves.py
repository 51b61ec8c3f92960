"""The mid-sagittal plane against the plane that the content was mirrored in."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from nodes.errors import BadInput
from nodes.imaging.mri_halves import Plane, find_midplane, left_half, side_of
from nodes.imaging.parameters import SegmentMriParameters
from tests.nodes.imaging.head_phantom import CENTRE, Phantom, draw

DEFAULTS = Path(__file__).resolve().parents[3] / "catalog" / "parameters" / "segment_mri.yml"
PARAMETERS = SegmentMriParameters(**yaml.safe_load(DEFAULTS.read_text()))


def turn(yaw_deg: float, roll_deg: float, pitch_deg: float = 0.0) -> np.ndarray:
    """About z, then about y, and before both about x, which leaves the midplane where it is."""
    (cz, cy, cx), (sz, sy, sx) = (
        f(np.deg2rad([yaw_deg, roll_deg, pitch_deg])) for f in (np.cos, np.sin)
    )
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    about_y = np.array([[cy, 0, -sy], [0, 1, 0], [sy, 0, cy]])
    return about_z @ about_y @ np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])


def apart_deg(a, b) -> float:
    return float(np.rad2deg(np.arccos(np.clip(a @ b, -1, 1))))


@pytest.mark.parametrize("turned", [turn(0, 0), turn(10, 0), turn(0, -10), turn(-20, 15, 10)])
def test_the_plane_turns_with_the_head(turned):
    mri, truth = draw(Phantom(voxel_mm=3.0, turned=turned, seed=2))
    brain = truth.voxels > 2
    plane = find_midplane(mri.voxels, brain, mri.patient_from_index, PARAMETERS)
    expected = turned @ [1.0, 0, 0]
    assert apart_deg(plane.normal, expected) < 0.5
    assert plane.offset_mm == pytest.approx(plane.normal @ CENTRE, abs=0.5)


def test_a_brain_that_is_nowhere_symmetric_is_refused():
    values = np.zeros((60, 60, 60), np.float32)
    values[:] = np.random.default_rng(5).normal(size=values.shape)
    brain = np.zeros(values.shape, bool)
    brain[8:30, 10:50, 10:25] = brain[20:50, 8:20, 20:50] = True
    with pytest.raises(BadInput, match="correlate"):
        find_midplane(values, brain, np.diag([3.0, 3, 3, 1]), PARAMETERS)


def test_sides_are_signed_distances_in_the_patient():
    normal = np.array([0.6, 0.0, 0.8])
    matrix = np.array([[0, -2.0, 0, 7], [3, 0, 0, 2], [0, 0, 5, -3], [0, 0, 0, 1]])
    sides = side_of(Plane(normal, 4.0), (3, 4, 5), matrix)
    for i, j, k in np.ndindex(3, 4, 5):
        point = matrix @ [i, j, k, 1]
        assert sides[i, j, k] == pytest.approx(normal @ point[:3] - 4.0, abs=1e-4)


def test_voxels_on_the_plane_are_shared():
    brain = np.zeros((21, 9, 8), bool)
    brain[3:18, 1:8, 2:7] = True
    matrix = np.diag([2.0, 2, 2, 1])
    matrix[0, 3] = -20
    left = left_half(Plane(np.array([1.0, 0, 0]), 0.0), brain, matrix)
    assert left[11:].sum() == brain[11:].sum() and not left[:10].any()
    assert abs(2 * int(left.sum()) - int(brain.sum())) <= 1
