"""Arcs are circles, and frames along them do not twist."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from nodes.mechanics.constant_curvature import Arcs, pose_arcs, pose_chain, sample_chain

angles = st.floats(-np.pi, np.pi)
curvatures = st.floats(1e-9, 0.1) | st.sampled_from([0.0, 1e-12, 1e-6])
lengths = st.floats(0.1, 100)


def arcs(*sections) -> Arcs:
    return Arcs(*np.array(sections, float).T.copy())


@given(angles, curvatures, lengths)
def test_the_end_is_where_the_matrix_of_the_paper_has_it(plane, curvature, length):
    """Rz(theta) Ry(psi) Rz(-theta) by scipy, and the place by integrating the tangent."""
    psi = curvature * length
    pose = pose_arcs(arcs((plane, curvature, length)))[0]
    turn = Rotation.from_euler("ZYZ", [plane, psi, -plane]).as_matrix()
    np.testing.assert_allclose(pose[:3, :3], turn, atol=1e-14)
    places, weights = np.polynomial.legendre.leggauss(30)
    along = psi * (places + 1) / 2
    aside, ahead = length / 2 * (weights @ np.sin(along)), length / 2 * (weights @ np.cos(along))
    expected = [aside * np.cos(plane), aside * np.sin(plane), ahead]
    np.testing.assert_allclose(pose[:3, 3], expected, atol=1e-12 * length)


def test_a_nearly_straight_arc_keeps_the_digits_of_its_sag():
    """l^2 gamma / 2, of which 1 - cos would leave nothing."""
    pose = pose_arcs(arcs((0.0, 1e-9, 10.0)))[0]
    assert pose[0, 3] == pytest.approx(5e-8, rel=1e-15)


@settings(max_examples=20)
@given(st.lists(st.tuples(angles, curvatures, lengths), min_size=1, max_size=4))
def test_a_chain_is_the_solution_of_its_differential_equation(sections):
    """p' = R e_z, R' = R [u]x, u = gamma (-sin, cos, 0), section by section."""
    place, turn = np.zeros(3), np.eye(3)
    for plane, curvature, length in sections:
        axis = curvature * np.array([-np.sin(plane), np.cos(plane), 0])
        cross = np.cross(np.eye(3), axis)

        def slope(s, state, cross=cross):
            frame = state[3:].reshape(3, 3)
            return np.concatenate([frame[:, 2], (frame @ cross).ravel()])

        start = np.concatenate([place, turn.ravel()])
        end = solve_ivp(slope, (0, length), start, "DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
        place, turn = end[:3], end[3:].reshape(3, 3)
    pose = pose_chain(arcs(*sections))[-1]
    np.testing.assert_allclose(pose[:3, 3], place, atol=1e-6)
    np.testing.assert_allclose(pose[:3, :3], turn, atol=1e-7)


@given(st.lists(st.tuples(angles, curvatures, lengths), min_size=1, max_size=4), st.floats(0, 1))
def test_an_arc_cut_in_two_ends_at_the_same_pose(sections, share):
    plane, curvature, length = sections[0]
    cut = [(plane, curvature, share * length), (plane, curvature, (1 - share) * length)]
    whole, halved = pose_chain(arcs(*sections)), pose_chain(arcs(*cut, *sections[1:]))
    np.testing.assert_allclose(halved[1:], whole, atol=1e-10)


@given(st.lists(st.tuples(angles, curvatures, lengths), min_size=1, max_size=4), angles)
def test_turning_every_plane_turns_the_chain(sections, turn):
    turned = [(plane + turn, curvature, length) for plane, curvature, length in sections]
    about = np.eye(4)
    about[:3, :3] = Rotation.from_rotvec([0, 0, turn]).as_matrix()
    expected = about @ pose_chain(arcs(*sections)) @ about.T
    np.testing.assert_allclose(pose_chain(arcs(*turned)), expected, atol=1e-10)


def test_samples_stand_on_the_chain_at_their_arc_length():
    chain = arcs((0.3, 0.02, 50.0), (-2.0, 0.0, 20.0), (1.0, 0.05, 30.0))
    places = np.linspace(0, 100, 4001)
    poses = sample_chain(chain, places)
    ends = pose_chain(chain)
    np.testing.assert_allclose(poses[[2000, 2800, 4000]], ends, atol=1e-12)
    steps = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    np.testing.assert_allclose(steps, 0.025, rtol=1e-6)
    np.testing.assert_allclose(sample_chain(chain, np.array([0.0, 999.0])), [np.eye(4), ends[-1]])


def test_many_chains_at_once_are_each_their_own():
    rng = np.random.default_rng(0)
    values = rng.uniform(0.1, 1, (3, 5, 4))
    together = pose_chain(Arcs(*values))
    for chain in range(5):
        np.testing.assert_array_equal(together[chain], pose_chain(Arcs(*values[:, chain])))
