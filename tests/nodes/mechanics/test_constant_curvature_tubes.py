"""Nested tubes bend to the least of their energy; who dominates is what the paper says."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from nodes.errors import BadInput
from nodes.mechanics.constant_curvature import pose_chain
from nodes.mechanics.constant_curvature_tubes import (
    arcs_of_robot,
    combine_curvatures,
    combine_section,
    count_dominating,
    insertion_lengths,
    is_follow_the_leader,
    measure_dominance,
    size_dominating_tube,
    total_lengths,
)
from nodes.mechanics.materials import make_material
from nodes.mechanics.robots import ConcentricTubeRobot
from tests.checkout import ROOT
from tests.nodes.mechanics.made_robots import concentric_tubes, joints, tube
from tests.nodes.mechanics.oracle_concentric_tubes import solve

TABLE = json.loads((ROOT / "tests/published/yang2019_table2.json").read_text())
rows = st.lists(
    st.tuples(st.floats(-3, 3), st.floats(0, 0.05), st.floats(1, 1000)), min_size=1, max_size=4
)


@settings(max_examples=50)
@given(rows)
def test_the_combined_curvature_has_the_least_bending_energy(tubes):
    """The energy is minimised by scipy, which is told nothing of its gradient."""
    plane, curvature, stiffness = np.array(tubes).T.copy()
    own = 1000 * curvature * np.array([np.cos(plane), np.sin(plane)])  # 1/m, for the minimiser
    weights = stiffness / stiffness.sum()
    least = minimize(lambda u: (weights * ((u[:, None] - own) ** 2).sum(0)).sum(), np.zeros(2))
    azimuth, combined = combine_curvatures(plane, curvature, stiffness)
    found = 1000 * combined * np.array([np.cos(azimuth), np.sin(azimuth)])
    np.testing.assert_allclose(found, least.x, atol=1e-4)


def test_aligned_tubes_average_and_opposed_tubes_subtract():
    """By stiffness, in closed form."""
    stiffness, curvature = np.array([10.0, 30.0]), np.array([0.02, 0.01])
    _, aligned = combine_curvatures(np.array([1.0, 1.0]), curvature, stiffness)
    assert aligned == pytest.approx((10 * 0.02 + 30 * 0.01) / 40, rel=1e-14)
    plane, opposed = combine_curvatures(np.array([1.0, 1.0 - np.pi]), curvature, stiffness)
    assert opposed == pytest.approx((30 * 0.01 - 10 * 0.02) / 40, rel=1e-13)
    assert plane == pytest.approx(1.0 - np.pi)


@pytest.mark.parametrize("row", TABLE["tests"], ids=lambda row: row["name"])
def test_tubes_of_the_paper_dominate_as_it_says(row):
    """Sec. III-B: each tube by more than 8 all inner ones; the steel is there to reach that."""
    stiffness = np.array(
        [
            tube(inner, outer, curvature=0.0, of=make_material(material)).bending_stiffness
            for inner, outer, material in zip(
                row["inner"], row["outer"], row["material"], strict=True
            )
        ]
    )
    dominance = measure_dominance(stiffness, np.ones(len(stiffness)))
    assert (dominance > TABLE["dominance"]).all()
    for tubes in range(2, len(stiffness) + 1):
        assert count_dominating(stiffness[:tubes], TABLE["dominance"]) == 1


def test_one_or_two_dominate_and_inner_tubes_yield_to_them():
    plane, curvature = np.array([0.0, 1.0, 2.0]), np.array([0.05, 0.02, 0.01])
    one, pair, none = [1.0, 2.0, 30.0], [1.0, 20.0, 20.0], [5.0, 20.0, 10.0]
    assert count_dominating(np.array([one, pair, none]), 8.0).tolist() == [1, 2, 3]
    azimuth, combined = combine_section(plane, curvature, np.array(one), 8.0)
    assert (azimuth, combined) == (pytest.approx(2.0), pytest.approx(0.01))
    found = combine_section(plane, curvature, np.array(pair), 8.0)
    expected = combine_curvatures(plane[1:], curvature[1:], np.array(pair[1:]))
    np.testing.assert_allclose(found, expected, rtol=1e-14)
    found = combine_section(plane, curvature, np.array(none), 8.0)
    np.testing.assert_allclose(found, combine_curvatures(plane, curvature, np.array(none)))


def test_a_robot_follows_its_leader_where_lengths_and_stiffness_are_in_order():
    thin, middle, thick = tube(0.8, 1.1, 200.0), tube(1.3, 2.2, 150.0), tube(2.4, 4.0, 90.0)
    base = np.eye(4)
    assert is_follow_the_leader(ConcentricTubeRobot((thin, middle, thick), base), 6.0)
    alike = (thin, tube(1.2, 1.4, 150.0), tube(1.5, 1.7, 90.0))
    assert not is_follow_the_leader(ConcentricTubeRobot(alike, base), 6.0)
    equal = tube(1.3, 2.2, 200.0)
    assert not is_follow_the_leader(ConcentricTubeRobot((thin, equal), base), 6.0)


@given(st.floats(0.5, 3), st.floats(1e3, 2e5), st.floats(1, 1e5), st.floats(1, 20))
def test_a_tube_of_the_size_asked_for_just_dominates(inner, modulus, stiffness, threshold):
    outer = size_dominating_tube(inner, modulus, stiffness, threshold)
    ring = np.pi / 64 * (outer**4 - inner**4)
    # The ring is a difference of nearly equal numbers where the wall is thin.
    slack = 1e-14 * outer**4 / (outer**4 - inner**4) * 100
    assert modulus * ring == pytest.approx(threshold * stiffness, rel=1e-9 + slack)


def test_dominance_weighs_stiffness_with_curvature():
    """[Yang2019] eq. (8) by hand: 40 x 0.01 / (10 x 0.02) = 2; straight ones do not count."""
    found = measure_dominance(np.array([10.0, 40.0]), np.array([0.02, 0.01]))
    np.testing.assert_allclose(found, [2.0], rtol=1e-14)
    assert measure_dominance(np.array([10.0, 40.0]), np.array([0.0, 0.01]))[0] == np.inf


def test_insertions_add_up_from_outside():
    """Eq. (2), and (3) with its conditions."""
    insertions = insertion_lengths(np.array([30.0, 20.0, 10.0]))
    assert insertions.tolist() == [60, 30, 10]
    assert total_lengths(insertions, np.array([9.0, 6.0, 3.0])).tolist() == [69, 36, 13]
    with pytest.raises(BadInput, match="drive parts"):
        total_lengths(insertions, np.array([9.0, 9.0, 3.0]))
    with pytest.raises(BadInput, match="insertions"):
        total_lengths(insertions[::-1].copy(), np.array([9.0, 6.0, 3.0]))


def test_aligned_tubes_are_arcs_in_the_torsionally_compliant_model_too():
    """Nothing twists where all planes agree, so the full model, solved slowly, gives these arcs."""
    robot, values = concentric_tubes(), joints((0.7, 0.7), (-60.0, -30.0))
    tip = pose_chain(arcs_of_robot(robot, values))[-1]
    np.testing.assert_allclose(tip[:3, 3], solve(robot, values).tip_point, atol=1e-7)


def test_one_tube_is_its_straight_part_and_its_arc():
    robot = ConcentricTubeRobot((tube(),), np.eye(4))
    arcs = arcs_of_robot(robot, joints((0.7,), (-60.0,)))
    np.testing.assert_allclose(arcs.length_mm, [40, 50])
    np.testing.assert_allclose(arcs.curvature_per_mm, [0, 0.02])
    assert arcs.bending_plane_rad[1] == pytest.approx(0.7)


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_a_robot_is_the_torsionally_rigid_model_integrated(seed):
    """A thousand small rotations, each with the curvature that holds at its place."""
    rng = np.random.default_rng(seed)
    robot = concentric_tubes()
    second = rng.uniform(-80, -5)
    first = rng.uniform(second - 60, second - 1)
    values = joints(rng.uniform(-3, 3, 2), (first, second))
    steps = 1000
    tip = first + 150
    place, frame, h = np.zeros(3), np.eye(3), tip / steps
    for s in (np.arange(steps) + 0.5) * h:
        total, x, y = 0.0, 0.0, 0.0
        for one, beta, angle in zip(
            robot.tubes, values.translations_mm, values.rotations_rad, strict=True
        ):
            if s < beta + one.length_mm:
                total += one.bending_stiffness
            if beta + one.straight_length_mm < s < beta + one.length_mm:
                x += one.bending_stiffness * one.curvature_per_mm * np.cos(angle)
                y += one.bending_stiffness * one.curvature_per_mm * np.sin(angle)
        axis = np.array([-y, x, 0]) / total * h
        cross = np.cross(np.eye(3), axis)
        place = place + h * frame @ (np.eye(3) + cross / 2) @ np.array([0, 0, 1.0])
        frame = frame @ (np.eye(3) + cross + cross @ cross / 2)
    pose = pose_chain(arcs_of_robot(robot, values))[-1]
    # A break lies anywhere in a step, which bends it by up to 0.02 / mm x step too much or little.
    np.testing.assert_allclose(pose[:3, 3], place, atol=0.02 * h * tip * 3)


def test_tubes_that_are_not_inserted_make_no_arcs():
    robot = ConcentricTubeRobot((tube(),), np.eye(4))
    assert arcs_of_robot(robot, joints((0.0,), (-150.0,))).length_mm.size == 0
