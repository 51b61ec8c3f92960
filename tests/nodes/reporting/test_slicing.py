from itertools import permutations, product

import numpy as np
import pytest

from nodes.reporting.slicing import (
    average_blocks,
    block_size,
    orient_to_patient,
    pick_blocks,
    reduced_transform,
    tilt_deg,
    to_grey,
)

ORIENTATIONS = [
    np.array(
        [
            [sign * (axis == row) for axis, sign in zip(order, signs, strict=True)]
            for row in range(3)
        ],
        float,
    )
    for order in permutations(range(3))
    for signs in product((1, -1), repeat=3)
]


def turned(angle_rad: float) -> np.ndarray:
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


@pytest.mark.parametrize("directions", ORIENTATIONS)
@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_every_voxel_keeps_its_place_in_the_patient(directions, tilt):
    voxels = np.arange(2 * 3 * 4).reshape(2, 3, 4)
    patient_from_index = np.eye(4)
    patient_from_index[:3, :3] = turned(tilt) @ directions @ np.diag([0.5, 1.5, 2.5])
    patient_from_index[:3, 3] = (7, -8, 9)
    oriented, patient_from_new = orient_to_patient(voxels, patient_from_index)
    for place in np.ndindex(voxels.shape):
        there = patient_from_index @ (*place, 1)
        new = np.rint(np.linalg.solve(patient_from_new, there)[:3]).astype(int)
        assert oriented[tuple(new)] == voxels[place]
        assert np.allclose(patient_from_new @ (*new, 1), there)
    assert (np.diag(patient_from_new)[:3] > 0).all()
    assert tilt_deg(patient_from_new) == pytest.approx(np.degrees(tilt), abs=1e-6)


@pytest.mark.parametrize("shape", [(8, 6, 4), (7, 5, 3), (1, 9, 2)])
def test_block_means_equal_brute_force(shape):
    values = np.random.default_rng(2).normal(size=shape).astype(np.float32)
    block = (3, 2, 1)
    means = average_blocks(values, block)
    for place in np.ndindex(means.shape):
        corners = [
            [min(p * b + step, n - 1) for step in range(b)]
            for p, b, n in zip(place, block, shape, strict=True)
        ]
        expected = np.mean([values[at] for at in product(*corners)])
        assert means[place] == pytest.approx(expected, abs=1e-5)


def test_blocks_leave_at_most_the_pixels_asked_for():
    shape = (512, 511, 133)
    block = block_size(shape, 256)
    assert block == (2, 2, 1)
    assert pick_blocks(np.zeros(shape, np.uint8), block).shape == (256, 256, 133)


def test_centre_of_a_block_is_the_mean_of_its_voxels():
    patient_from_index = np.array([[0, 2, 0, 5], [3, 0, 0, 6], [0, 0, 4, 7], [0, 0, 0, 1]], float)
    reduced = reduced_transform(patient_from_index, (2, 3, 1))
    members = [(2, 3, 4), (2, 4, 4), (2, 5, 4), (3, 3, 4), (3, 4, 4), (3, 5, 4)]
    centres = [patient_from_index @ (*member, 1) for member in members]
    assert np.allclose(reduced @ (1, 1, 4, 1), np.mean(centres, axis=0))


def test_labels_are_picked_from_their_own_block():
    labels = np.arange(9 * 7 * 3).reshape(9, 7, 3).astype(np.uint8)
    block = (2, 3, 1)
    picked = pick_blocks(labels, block)
    for place in np.ndindex(picked.shape):
        own = tuple(slice(p * b, (p + 1) * b) for p, b in zip(place, block, strict=True))
        assert picked[place] in labels[own]


def test_grey_follows_the_curve_and_ends_at_its_ends():
    knots, greys = (-1024.0, -200.0, 300.0, 2000.0), (0.0, 60.0, 196.0, 255.0)
    values = np.linspace(-3000, 4000, 5000, dtype=np.float32).reshape(10, 20, 25)
    grey = to_grey(values, knots, greys)
    assert np.abs(grey - np.interp(values, knots, greys)).max() <= 0.6
    odd = np.array([[[np.nan, np.inf, -np.inf]]], np.float32)
    assert to_grey(odd, knots, greys).tolist() == [[[0, 255, 0]]]
