"""Random configurations, and edges laid between them, against scipy."""

from itertools import pairwise

import numpy as np
import pytest
from numba import njit
from scipy import stats
from scipy.spatial.transform import Rotation

from nodes.kernels import crisp_tree_chance as chance_kernels
from nodes.kernels.crisp_tree_chance import Region, draw_configuration
from nodes.kernels.crisp_tree_front import Scale, aim, count_upright
from nodes.planning.tree_memory import Sizes, make_front

draw, turn_between, turn_quaternion, multiply = (
    chance_kernels.draw,
    chance_kernels.turn_between,
    chance_kernels.turn_quaternion,
    chance_kernels.multiply,
)
TILT = np.radians(40.0)


@njit
def _draw_numbers(chance, numbers):
    for place in range(len(numbers)):
        numbers[place] = draw(chance)


@njit
def _draw_configurations(chance, region, quaternions, lengths):
    for place in range(len(lengths)):
        draw_configuration(chance, region, quaternions[place], lengths[place])


@njit
def _lay_edge(front, quaternions, lengths, scale, region):
    return aim(front, 0, quaternions, lengths, scale), count_upright(front, 0, region)


@njit
def _turn(a, b, share):
    turn = turn_between(a, b)
    return turn, multiply(turn_quaternion(turn, share), a)


def drawn(count=4000, seed=7):
    """Two needles, the second of which hardly tilts and keeps its length."""
    axes = np.array([[1.0, 0, 0, 0], [np.cos(0.7), np.sin(0.7), 0, 0]])
    shortest, longest = np.array([20.0, 50.0]), np.array([120.0, 50.0])
    directions = Rotation.from_quat(axes, scalar_first=True).apply([0.0, 0, 1])
    region = Region(axes, directions, np.cos([TILT, 1e-6]), shortest, longest)
    quaternions, lengths = np.zeros((count, 2, 4)), np.zeros((count, 2))
    _draw_configurations(np.array([seed], np.uint64), region, quaternions, lengths)
    return region, quaternions, lengths


def test_numbers_are_those_of_the_published_generator():
    numbers = np.zeros(3)
    _draw_numbers(np.array([1234567], np.uint64), numbers)
    expected = [6457827717110365317, 3203168211198807973, 9817491932198370423]
    assert numbers.tolist() == [(number >> 11) * 2.0**-53 for number in expected]


def test_tangents_fill_their_cones_evenly():
    _, quaternions, _ = drawn()
    tangents = Rotation.from_quat(quaternions[:, 0], scalar_first=True).apply([0.0, 0, 1])
    heights = (1 - tangents[:, 2]) / (1 - np.cos(TILT))
    around = np.arctan2(tangents[:, 1], tangents[:, 0]) / (2 * np.pi) + 0.5
    assert stats.kstest(heights, "uniform").pvalue > 1e-3
    assert stats.kstest(around, "uniform").pvalue > 1e-3
    assert heights.max() <= 1 + 1e-12


def test_axes_point_where_the_region_says():
    region, quaternions, lengths = drawn(50)
    axis = Rotation.from_quat(region.axes[1], scalar_first=True).apply([0.0, 0, 1])
    tangents = Rotation.from_quat(quaternions[:, 1], scalar_first=True).apply([0.0, 0, 1])
    assert np.abs(tangents - axis).max() < 1e-5
    assert (lengths[:, 1] == 50.0).all()


def test_lengths_and_rolls_are_even():
    _, quaternions, lengths = drawn()
    assert stats.kstest((lengths[:, 0] - 20) / 100, "uniform").pvalue > 1e-3
    rolls = 2 * np.arctan2(quaternions[:, 1, 3], quaternions[:, 1, 0])
    assert stats.kstest(np.mod(rolls / (2 * np.pi), 1), "uniform").pvalue > 1e-3


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_turns_are_the_shortest_and_shares_of_them_lie_on_the_geodesic(sign):
    rng = np.random.default_rng(4)
    for _ in range(50):
        a, b = (Rotation.random(rng=rng) for _ in range(2))
        quaternions = a.as_quat(scalar_first=True), sign * b.as_quat(scalar_first=True)
        turn, between = _turn(*map(tuple, quaternions), 0.3)
        expected = (b * a.inv()).as_rotvec()
        assert np.abs(np.array(turn) - expected).max() < 1e-9
        there = Rotation.from_quat(between, scalar_first=True)
        assert (there * (Rotation.from_rotvec(0.3 * expected) * a).inv()).magnitude() < 1e-9


def test_edges_are_upright_up_to_the_step_at_which_a_needle_leaves_its_cone():
    region, quaternions, lengths = drawn(150)
    region = region._replace(heights=np.cos([TILT, TILT]))
    quaternions[:, 1] = quaternions[::-1, 0]
    axes = np.array([[0.0, 0, 1], [0, 0, 1]])
    region = region._replace(directions=axes)
    front, scale = make_front(Sizes(2, 1, 4, 8)), Scale(1.0, np.ones(1), np.zeros(1), 0.02, 50.0)
    leaving = 0
    for start, end in pairwise(quaternions):
        front.quaternions[0] = start
        count, upright = _lay_edge(front, end, lengths[0], scale, region)
        fine = np.linspace(0, count, 10 * count + 1)
        tilts = np.stack([_tilts(*pair, fine / count) for pair in zip(start, end, strict=True)])
        inside = (tilts <= TILT + 1e-9).all(axis=0)
        assert inside[fine <= upright].all()
        if upright < count:
            leaving += 1
            beyond = (fine > upright) & (fine < upright + 0.2)
            assert (tilts[:, beyond] > TILT - 1e-9).any(axis=0).all()
        else:
            assert inside.all()
    assert leaving > 0


def _tilts(start, end, shares):
    """Tilts from e_z along the geodesic, by scipy."""
    a, b = (Rotation.from_quat(q, scalar_first=True) for q in (start, end))
    turned = Rotation.from_rotvec(shares[:, None] * (b * a.inv()).as_rotvec()) * a
    t = turned.apply([0.0, 0, 1])
    return np.arctan2(np.hypot(t[:, 0], t[:, 1]), t[:, 2])
