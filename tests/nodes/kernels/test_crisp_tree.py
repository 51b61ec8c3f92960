"""Random configurations, and edges laid between them, against scipy."""

import numpy as np
import pytest
from numba import njit
from scipy import stats
from scipy.spatial.transform import Rotation

from nodes.kernels import crisp_tree_chance as chance_kernels
from nodes.kernels.crisp_tree_chance import Region, draw_configuration

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
def _turn(a, b, share):
    turn = turn_between(a, b)
    return turn, multiply(turn_quaternion(turn, share), a)


def drawn(count=4000, seed=7):
    """Two needles, the second of which hardly tilts and keeps its length."""
    axes = np.array([[1.0, 0, 0, 0], [np.cos(0.7), np.sin(0.7), 0, 0]])
    shortest, longest = np.array([20.0, 50.0]), np.array([120.0, 50.0])
    region = Region(axes, np.cos([TILT, 1e-6]), shortest, longest)
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
