"""Unbent starts: straight needles that meet at right angles, within their limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nodes.errors import BadInput
from nodes.planning.setup_starts import (
    Entries,
    Limits,
    lay_starts,
    read_entries,
    roll_needles,
    spread_tangents,
)
from tests.nodes.planning.made_cavity import ENTRIES, entry_table

LIMITS = Limits(np.radians(50), 5.0, 120.0, 20.0)


def entries_of(seed, count=4):
    random = np.random.default_rng(seed)
    points = random.uniform(-60, 60, (count, 3))
    axes = -points / np.linalg.norm(points, axis=1, keepdims=True)
    return Entries(np.arange(1, count + 1), points, axes)


@settings(max_examples=20)
@given(st.integers(0, 1000))
def test_straight_needles_meet_at_right_angles_within_all_limits(seed):
    entries = entries_of(seed)
    tangents = spread_tangents(entries.axes, LIMITS.tilt_rad, 30)
    starts = lay_starts(entries, tangents, 10.0, LIMITS)
    tools, snares = entries.points[starts.tools], entries.points[starts.snares]
    on_tool = tools + starts.feet_mm[:, None] * starts.tangents
    on_snare = snares + starts.reaches_mm[:, None] * starts.snare_tangents
    np.testing.assert_allclose(on_tool, on_snare, atol=1e-9)
    across = np.einsum("ni,ni->n", starts.tangents, starts.snare_tangents)
    np.testing.assert_allclose(across, 0, atol=1e-9)
    for rows, tangent in ((starts.tools, starts.tangents), (starts.snares, starts.snare_tangents)):
        cosine = np.einsum("ni,ni->n", entries.axes[rows], tangent)
        assert (np.arccos(np.clip(cosine, -1, 1)) <= LIMITS.tilt_rad + 1e-6).all()
    for lengths in (starts.feet_mm + 10, starts.reaches_mm):
        assert ((lengths >= 5) & (lengths <= 120)).all()
    assert (np.linalg.norm(tools - snares, axis=1) >= 20).all()
    keys = starts.tools * 10 + starts.snares
    assert (np.diff(keys) >= 0).all()


def test_starts_are_found_wherever_the_tool_is_aimed_at_a_right_angle():
    points = np.array([[0.0, 0, 0], [30.0, 0, 40]])
    axes = np.array([[0.0, 0, 1], [-1.0, 0, 0]])
    entries = Entries(np.arange(2), points, axes)
    along = np.repeat(axes[:, None], 1, axis=1)
    starts = lay_starts(entries, along, 10.0, LIMITS)
    assert starts.tools.tolist() == [0, 1] and starts.snares.tolist() == [1, 0]
    assert starts.feet_mm.tolist() == [40.0, 30.0] and starts.reaches_mm.tolist() == [30.0, 40.0]
    np.testing.assert_allclose(starts.snare_tangents, [[-1, 0, 0], [0, 0, 1]])


def test_rolls_are_those_that_a_rigid_joint_wants():
    """[Kuntz2017] eq. (6), with needles that are straight from entry to joint."""
    entries = entries_of(3)
    tangents = spread_tangents(entries.axes, LIMITS.tilt_rad, 10)
    starts = lay_starts(entries, tangents, 10.0, LIMITS)
    tools, snares = roll_needles(starts.tangents, starts.snare_tangents)
    turn = Rotation.from_rotvec([-np.pi / 2, 0, 0]).as_matrix()
    left = tools.swapaxes(1, 2) @ snares @ turn
    assert len(left) > 3
    np.testing.assert_allclose(left, np.tile(np.eye(3), (len(left), 1, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(tools), 1)
    np.testing.assert_array_equal(tools[..., 2], starts.tangents)
    np.testing.assert_array_equal(snares[..., 2], starts.snare_tangents)


@settings(max_examples=20)
@given(st.integers(0, 1000), st.floats(0.1, 1.5), st.integers(1, 80))
def test_directions_fill_the_cone_evenly_and_no_more(seed, tilt, count):
    axes = entries_of(seed).axes
    tangents = spread_tangents(axes, tilt, count)
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=-1), 1)
    cosine = np.einsum("ndi,ni->nd", tangents, axes)
    assert (cosine >= np.cos(tilt) - 1e-12).all()
    shares = (1 - np.sort(cosine, axis=1)[:, ::-1]) / (1 - np.cos(tilt))
    np.testing.assert_allclose(shares, np.tile((np.arange(count) + 0.5) / count, (4, 1)), atol=1e-6)


def test_only_rows_into_the_free_space_are_used():
    table = entry_table(ENTRIES)
    table.loc[1, "part"] = "part_2"
    entries = read_entries(table, 2)
    assert entries.numbers.tolist() == [1, 3, 4, 5, 6]
    np.testing.assert_allclose(entries.points[1], table.loc[2, "pleura_x_mm":"pleura_z_mm"])


def test_tables_without_enough_usable_rows_are_refused_with_the_reason():
    with pytest.raises(BadInput, match="is empty") as error:
        read_entries(entry_table([]), 2)
    assert "without a bone label" in error.value.cure
    other = entry_table(ENTRIES, part="part_2")
    other.loc[0, "part"] = "free"
    with pytest.raises(BadInput, match=r"1 of 6 entries .* 5 lead into part_2"):
        read_entries(other, 2)
