"""Arcs go through the points they were asked for, and the paper's table comes out."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nodes.errors import BadInput
from nodes.mechanics.constant_curvature import Arcs, pose_arcs, pose_chain
from nodes.mechanics.constant_curvature_inverse import (
    ARC,
    EMPTY,
    IMPOSSIBLE,
    STRAIGHT,
    check_possible,
    fit_arcs,
    fit_chain,
)
from tests.checkout import ROOT

TABLE = json.loads((ROOT / "tests/published/yang2019_table1.json").read_text())["tests"]
coordinates = st.floats(-100, 100)


@pytest.mark.parametrize("row", TABLE, ids=["test 1", "test 2", "test 3"])
def test_table_1_comes_out_to_all_printed_digits(row):
    fitted = fit_chain(np.array(row["nodes"], float), np.eye(3))
    found = {
        "theta": fitted.arcs.bending_plane_rad,
        "gamma": fitted.arcs.curvature_per_mm,
        "psi": fitted.arcs.central_angle_rad,
        "length": fitted.arcs.length_mm,
    }
    assert fitted.kinds.tolist() == row["flag"]
    for name, values in found.items():
        for value, printed in zip(values, row[name], strict=True):
            if printed == "15.70":  # the paper multiplied rounded numbers; see the file's note
                assert value == pytest.approx(5 * np.pi, rel=1e-12)
            elif printed is None:  # a straight section has no curvature and no angle
                assert value == 0
            else:
                digits = len(printed.partition(".")[2])
                assert f"{value:.{digits}f}".removeprefix("-0") == printed.removeprefix("-0")


@given(st.floats(-np.pi, np.pi), st.floats(1e-9, 0.99), st.floats(0.01, 500))
def test_an_arc_is_found_again_from_its_end(plane, turns, length):
    """From nearly straight to nearly a full circle."""
    psi = 2 * np.pi * turns
    end = pose_arcs(Arcs(*np.array([[plane], [psi / length], [length]])))[:, :3, 3]
    fitted = fit_arcs(end)
    assert fitted.kinds[0] == ARC
    np.testing.assert_allclose(fitted.arcs.length_mm, length, rtol=1e-12)
    np.testing.assert_allclose(fitted.arcs.curvature_per_mm, psi / length, rtol=1e-12)
    off = np.exp(1j * fitted.arcs.bending_plane_rad) / np.exp(1j * plane) - 1
    assert abs(off).max() < 1e-12


@given(coordinates, coordinates, coordinates)
def test_an_arc_ends_at_its_point_and_leaves_along_z(x, y, z):
    point = np.array([[x, y, z]])
    fitted = fit_arcs(point)
    if fitted.kinds[0] != IMPOSSIBLE:
        found = pose_arcs(fitted.arcs)[:, :3, 3]
        # Rounding of the central angle shows at the end in proportion to the radius of the turn.
        np.testing.assert_allclose(
            found, point, atol=2e-15 * max(fitted.arcs.length_mm[0], 1.0) * 10
        )
        assert 0 <= fitted.arcs.central_angle_rad[0] <= 2 * np.pi


def test_nearly_straight_arcs_have_their_curvature():
    """gamma = 2 rho / |C|^2."""
    fitted = fit_arcs(np.array([[5e-8, 0, 10.0]]))
    assert fitted.arcs.curvature_per_mm[0] == pytest.approx(1e-9, rel=1e-14)
    assert fitted.kinds[0] == ARC


def test_special_cases_of_the_paper():
    """Straight ahead, the start itself, and straight behind."""
    fitted = fit_arcs(np.array([[0, 0, 7.0], [0, 0, 0], [0, 0, -7]]))
    assert fitted.kinds.tolist() == [STRAIGHT, EMPTY, IMPOSSIBLE]
    np.testing.assert_array_equal(fitted.arcs.length_mm, [7, 0, np.nan])
    np.testing.assert_array_equal(fitted.arcs.bending_plane_rad, [0, 0, np.nan])
    np.testing.assert_array_equal(fitted.arcs.curvature_per_mm, [0, 0, np.nan])


sections = st.tuples(st.floats(-3.1, 3.1), st.floats(1e-6, 1.8 * np.pi), st.floats(1, 100))
turns = st.tuples(*[st.floats(-3, 3)] * 3)


@given(st.lists(sections, min_size=1, max_size=4), turns, st.tuples(*[coordinates] * 3))
def test_a_chain_is_found_again_from_its_nodes_in_any_frame(sections, turn, place):
    plane, psi, length = np.array(sections).T.copy()
    chain = Arcs(plane, psi / length, length)
    axes = Rotation.from_rotvec(turn).as_matrix()
    ends = np.concatenate([np.zeros((1, 3)), pose_chain(chain)[:, :3, 3]])
    fitted = fit_chain(ends @ axes.T + np.array(place), axes)
    np.testing.assert_allclose(fitted.arcs.length_mm, length, rtol=1e-6)
    np.testing.assert_allclose(fitted.arcs.central_angle_rad, psi, rtol=1e-6, atol=1e-9)


def paper_chain(nodes: np.ndarray) -> np.ndarray:
    """Return (section, 4) theta, gamma, psi, s by [Yang2019] eq. (15) to (20) as they are printed.

    All later nodes are moved to the section's start and turned back about xi = (-sin, cos, 0).
    """
    later, found = nodes[1:] - nodes[0], []
    for section in range(len(later)):
        x, y, z = later[section]
        theta, aside = np.arctan2(y, x), np.hypot(x, y)
        gamma = 2 * aside / (aside**2 + z**2)
        psi = np.arccos(1 - gamma * aside)
        psi = psi if z > 0 else 2 * np.pi - psi
        found.append([theta, gamma, psi, psi / gamma])
        back = Rotation.from_rotvec(-psi * np.array([-np.sin(theta), np.cos(theta), 0]))
        later = back.apply(later - later[section])
    return np.array(found)


@given(st.integers(0, 2**32 - 1))
def test_chains_are_those_of_the_paper_step_by_step(seed):
    nodes = np.random.default_rng(seed).normal(scale=10, size=(4, 3))
    arcs, expected = fit_chain(nodes, np.eye(3)).arcs, paper_chain(nodes).T
    np.testing.assert_allclose(np.exp(1j * (arcs.bending_plane_rad - expected[0])), 1, atol=1e-6)
    np.testing.assert_allclose(arcs.curvature_per_mm, expected[1], rtol=1e-6)
    # acos loses half of the digits near the ends of its range.
    np.testing.assert_allclose(arcs.central_angle_rad, expected[2], atol=1e-6)
    np.testing.assert_allclose(arcs.length_mm, expected[3], rtol=1e-5)


@given(st.lists(st.tuples(*[coordinates] * 3), min_size=2, max_size=5))
def test_a_chain_passes_its_nodes(nodes):
    nodes = np.array([(0.0, 0, 0), *nodes])
    fitted = fit_chain(nodes, np.eye(3))
    possible = np.flatnonzero(np.cumsum(fitted.kinds == IMPOSSIBLE) == 0)
    found = pose_chain(fitted.arcs)[possible, :3, 3]
    # A section near a full circle multiplies rounding: the node after it is a hair's breadth off.
    slack = 1e-9 * max(1.0, np.nan_to_num(fitted.arcs.length_mm[possible]).max(initial=0))
    np.testing.assert_allclose(found, nodes[1:][possible], atol=slack)


def test_what_follows_an_impossible_section_is_impossible_and_refused_by_its_node():
    nodes = np.array([[0.0, 0, 0], [0, 0, 5], [0, 0, 2], [1, 1, 1]])
    fitted = fit_chain(nodes, np.eye(3))
    assert fitted.kinds.tolist() == [STRAIGHT, IMPOSSIBLE, IMPOSSIBLE]
    with pytest.raises(BadInput, match="node 2 lies straight behind node 1"):
        check_possible(fitted)
    check_possible(fit_chain(nodes[:2], np.eye(3)))


def test_many_chains_at_once_are_each_their_own():
    nodes = np.random.default_rng(1).normal(size=(6, 4, 3))
    together = fit_chain(nodes, np.eye(3))
    for chain in range(6):
        alone = fit_chain(nodes[chain], np.eye(3))
        np.testing.assert_allclose(together.arcs.length_mm[chain], alone.arcs.length_mm, rtol=1e-12)
        np.testing.assert_array_equal(together.kinds[chain], alone.kinds)
