"""Straightened stacks: objects of known size and place keep both, at any tilt."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nodes.imaging.straightening import PlaneStack, even_out, straighten
from tests.nodes.imaging.made_planes import places, read, stack

SEMI_AXES = np.array([17.0, 23.0, 14.0])
CENTRE = np.array([5.0, -40.0, 120.0])


def soft_ellipsoid(points):
    """1000 HU inside, -1000 outside, over an edge about 4 mm wide: sampling hardly tells."""
    scaled = (points - CENTRE) / SEMI_AXES
    radius = np.linalg.norm(scaled, axis=-1)
    gradient = np.linalg.norm(scaled / SEMI_AXES, axis=-1)
    depth_mm = (1 - radius) * radius / np.maximum(gradient, 1e-9)
    return np.clip(depth_mm / 2, -1, 1) * 1000


def scan(axes, tilt_deg, toward, step=2.0, spacing=(0.9, 1.1)):
    """Planes through the whole ellipsoid, leaning by the tilt toward an angle within the plane."""
    lean = np.tan(np.deg2rad(tilt_deg)) * np.array([np.cos(toward), np.sin(toward)])
    heights = np.arange(-34, 34, step)
    return stack(heights, soft_ellipsoid, axes, lean, (84, 96), spacing, CENTRE)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.6, 30), st.floats(0, 6.28), st.integers(0, 99))
def test_an_ellipsoid_keeps_volume_and_centre_at_any_tilt(tilt_deg, toward, seed):
    axes = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    volume = read(scan(axes, tilt_deg, toward))
    assert any(f"leaned by {tilt_deg:.1f} deg" in notice for notice in volume.origin.notices)
    matrix = volume.patient_from_index[:3, :3]
    crossed = matrix.T @ matrix
    np.testing.assert_allclose(crossed, np.diag(np.diag(crossed)), atol=1e-6)
    inside = volume.voxels.reshape(-1) >= 0
    ml = inside.sum() * abs(np.linalg.det(matrix)) / 1000
    assert ml == pytest.approx(4 / 3 * np.pi * np.prod(SEMI_AXES) / 1000, rel=0.01)
    np.testing.assert_allclose(places(volume)[inside].mean(axis=0), CENTRE, atol=0.1)


def test_read_as_if_straight_it_would_be_larger_by_the_inverse_cosine():
    """What the correction is for: the same planes, stacked without their sideways shifts."""
    planes = scan(np.eye(3), 30, 1.57)
    steps = [np.linalg.norm(planes[1].patient_from_pixel[:3, 3]
                            - planes[0].patient_from_pixel[:3, 3]), 0.9, 1.1]  # fmt: skip
    inside = sum(int((plane.pixels >= 0).sum()) for plane in planes)
    true = 4 / 3 * np.pi * np.prod(SEMI_AXES)
    assert inside * np.prod(steps) / true == pytest.approx(1 / np.cos(np.deg2rad(30)), rel=0.01)


@pytest.mark.parametrize(
    ("modality", "unit", "tissue", "outside"),
    [("CT", "HU", -500, -1024), ("MR", "intensity", 500, 0)],
)
def test_what_was_not_scanned_is_empty_and_nothing_that_was_is_lost(
    modality, unit, tissue, outside
):
    planes = stack(
        range(9), lambda points: 0 * points[..., 0] + tissue, np.eye(3), (0, 0.4), (10, 12), (1, 1),
        unit=unit, modality=modality,
    )  # fmt: skip
    planes[0] = replace(planes[0], pixels=0 * planes[0].pixels)
    volume = read(planes, modality=modality)
    assert volume.voxels.shape == (12, 14, 9)
    assert set(np.unique(volume.voxels)) == {outside, 0, tissue}
    assert (volume.voxels[:, :, 1:] == tissue).sum(axis=(0, 1)).min() >= 12 * 9
    assert any(f"set to {outside}" in notice for notice in volume.origin.notices)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(st.integers(-4, 4), st.integers(-4, 4)), min_size=3, max_size=6))
def test_shifts_by_whole_pixels_copy_every_value_to_its_place(shifts):
    chance = np.random.default_rng(0)
    voxels = chance.integers(-1000, 1000, (5, 7, len(shifts))).astype(np.int16)
    positions = np.array([[0.7 * i, 0.9 * j, 2.0 * k] for k, (i, j) in enumerate(shifts)])
    axes = np.array([[0.7, 0, 0], [0, 0.9, 0], [0, 0, 1.0]])
    straight = straighten(PlaneStack(voxels, axes, positions), -2000.0)
    values = {}
    for k in range(len(shifts)):
        for i, j in np.argwhere(straight.voxels[:, :, k] > -2000):
            place = straight.positions[k] + axes[:, :2] @ [i, j]
            values[tuple(np.round(place, 6))] = straight.voxels[i, j, k]
    assert len(values) == voxels.size
    for (i, j, k), value in np.ndenumerate(voxels):
        place = positions[k] + axes[:, :2] @ [i, j]
        assert values[tuple(np.round(place, 6) + 0.0)] == value


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(0.3, 7), min_size=2, max_size=12))
def test_even_steps_follow_a_straight_course_and_keep_both_ends(steps):
    heights = np.concatenate([[3.0], 3.0 + np.cumsum(steps)])
    axes = np.array([[0.5, 0, 0], [0, 0.5, 0], [0, 0, 1.0]])
    course = np.array([0.1, -0.2, 1.0])
    voxels = np.broadcast_to(10 * heights, (2, 3, len(heights))).astype(np.float32)
    even = even_out(PlaneStack(voxels, axes, np.outer(heights, course)), 0.05)
    new = even.heights()
    np.testing.assert_allclose(np.diff(new), new[1] - new[0], atol=1e-9)
    np.testing.assert_allclose(new[[0, -1]], heights[[0, -1]])
    assert new[1] - new[0] <= max(min(steps), 0.5) + 0.05 + 1e-9
    np.testing.assert_allclose(even.voxels[1, 2], 10 * new, rtol=1e-5)
    np.testing.assert_allclose(even.positions, np.outer(new, course), atol=1e-9)
