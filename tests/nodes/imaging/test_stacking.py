"""Stacking planes: order comes from positions, and what is no even stack is refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nodes.errors import BadInput
from tests.nodes.imaging.made_planes import linear_field, places, read, stack

AXIAL = np.eye(3)
CORONAL = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
SAGITTAL = np.array([[0.0, 0, -1], [1, 0, 0], [0, -1, 0]])


@settings(max_examples=25, deadline=None)
@given(st.permutations(range(6)), st.integers(0, 99), st.floats(0.3, 9), st.booleans())
def test_every_voxel_lies_where_its_value_says_for_any_order_of_files(order, seed, step, reverse):
    axes = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    if reverse:
        axes = axes * [1, -1, -1]  # rows listed upwards: the normal points down
    slices = stack(step * np.arange(6), axes=axes)
    volume = read([slices[index] for index in order])
    values = linear_field(places(volume))
    np.testing.assert_allclose(volume.voxels.reshape(-1), values, rtol=1e-4, atol=1e-3)
    assert np.linalg.det(volume.patient_from_index[:3, :3]) > 0
    assert volume.voxels.shape == (6, 4, 6)
    assert volume.origin.notices == ()


@pytest.mark.parametrize("axes", [AXIAL, CORONAL, SAGITTAL], ids=["axial", "coronal", "sagittal"])
def test_scans_along_any_body_axis_keep_their_places(axes):
    volume = read(stack(np.arange(5) * 2.0, axes=axes))
    np.testing.assert_allclose(
        volume.voxels.reshape(-1), linear_field(places(volume)), rtol=1e-4, atol=1e-3
    )


@settings(max_examples=30, deadline=None)
@given(st.integers(5, 40), st.floats(0.05, 8), st.data())
def test_a_missing_plane_is_refused_with_its_place(count, step, data):
    gone = data.draw(st.integers(1, count - 2))
    start = data.draw(st.floats(-500, 500))
    heights = start + step * np.delete(np.arange(count), gone)
    between = rf"between planes {gone} and {gone + 1} of {count - 1}"
    with pytest.raises(BadInput, match=between) as caught:
        read(stack(heights, axes=AXIAL))
    assert f"{2 * step:.2f} mm" in caught.value.value
    assert f"{heights[gone - 1]:.1f} and {heights[gone]:.1f} mm" in caught.value.value


@settings(max_examples=20, deadline=None)
@given(st.integers(3, 20), st.data())
def test_a_doubled_plane_is_refused_with_its_place(count, data):
    twice = data.draw(st.integers(0, count - 1))
    heights = np.sort([*range(count), twice])
    with pytest.raises(BadInput, match=f"one place, between planes {twice + 1} and {twice + 2}"):
        read(stack(heights))


@pytest.mark.parametrize(
    ("heights", "words"),
    [
        ([0, 1, 2.3, 3, 4], "distances between planes from 0.70 to 1.30 mm"),
        ([0], "one plane only"),
        ([0, 1], "2 planes only"),
        ([7, 7, 7, 7], "4 planes at one place"),
    ],
)
def test_shifted_few_and_piled_planes_are_refused(heights, words):
    with pytest.raises(BadInput, match=words):
        read(stack(heights))


@pytest.mark.parametrize("step", [0.6667, 0.3, 1.25])
def test_rounded_positions_are_accepted(step):
    heights = np.round(np.arange(200) * step, 1)
    assert read(stack(heights)).voxels.shape[2] == 200


def test_a_plane_shifted_sideways_is_refused():
    slices = stack(range(8))
    moved = slices[3].patient_from_pixel.copy()
    moved[:3, 3] += moved[:3, 0]
    slices[3] = replace(slices[3], patient_from_pixel=moved)
    with pytest.raises(BadInput, match=r"sideways by up to 0.50 mm"):
        read(slices)


def test_planes_in_hu_and_planes_without_are_refused():
    slices = stack(range(4)) + stack([4], unit="intensity")
    with pytest.raises(BadInput, match="planes in HU and planes without"):
        read(slices)


def test_a_lean_beyond_any_gantry_is_refused():
    with pytest.raises(BadInput, match=r"leans by 45.0 deg\n  rule: a gantry tilts by 35 deg"):
        read(stack(range(8), lean=(0, 1)))


def test_uneven_planes_are_filled_only_when_asked_and_only_over_small_gaps():
    heights = np.array([0, 1.1, 2.2, 6.4, 10.6, 18.0, 25.4])
    with pytest.raises(BadInput, match=r"from 1.10 to 7.40 mm"):
        read(stack(heights))
    with pytest.raises(BadInput, match="gaps up to 5 mm may be filled"):
        read(stack(heights), uneven_spacing="resample", largest_gap_mm=5)
    volume = read(stack(heights), uneven_spacing="resample")
    assert any("7.40 mm apart" in notice and "estimate" in notice
               for notice in volume.origin.notices)  # fmt: skip
    step = np.linalg.norm(volume.patient_from_index[:3, 2])
    assert step <= 1.2 and step * (volume.voxels.shape[2] - 1) == pytest.approx(25.4)
    np.testing.assert_allclose(
        volume.voxels.reshape(-1), linear_field(places(volume)), rtol=1e-4, atol=1e-3
    )


def test_what_is_uneven_and_leans_is_mended_for_both():
    heights = np.array([0, 1, 2, 4, 5, 6, 7])
    volume = read(stack(heights, lean=(0, 0.3), shape=(9, 6)), uneven_spacing="resample")
    values, wanted = volume.voxels.reshape(-1), linear_field(places(volume))
    scanned = values > -1024
    np.testing.assert_allclose(values[scanned], wanted[scanned], rtol=1e-4, atol=1e-2)
    assert scanned.sum() >= 8 * 8 * 6
    assert [notice[:9] for notice in volume.origin.notices] == ["planes la", "the stack"]
