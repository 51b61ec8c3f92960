"""Configurations that a robot cannot take are refused with the tube or needle and its numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nodes.errors import BadInput
from nodes.mechanics.check_robots import (
    check_concentric_tube_configuration,
    check_crisp_configuration,
    grasp_arc_mm,
)
from nodes.mechanics.robots import PointLoad, Snare
from tests.nodes.mechanics.made_robots import concentric_tubes, crisp, joints, needle, poses


@pytest.mark.parametrize(
    ("translations", "told"),
    [
        ((-40.0, 1.0), r"translations_mm\[1\] = 1 mm"),
        ((-10.0, -20.0), r"translations_mm\[0\] = -10 mm, beyond the base of tubes\[1\] at -20 mm"),
        ((-100.0, -20.0), r"tubes\[0\] ends at 50 mm, inside of tubes\[1\], which ends at 65 mm"),
        ((-120.0, -90.0), r"tubes\[1\] ends at -5 mm, behind the entry plane"),
        ((np.nan, -20.0), "finite"),
        ((-40.0,), "translations: 1"),
    ],
)
def test_tubes_that_pass_each_other_are_refused(translations, told):
    with pytest.raises(BadInput, match=told):
        check_concentric_tube_configuration(
            concentric_tubes(), joints((0.0,) * len(translations), translations)
        )


@given(st.floats(-200, 20), st.floats(-200, 20))
def test_a_configuration_is_refused_exactly_where_an_end_is_out_of_order(first, second):
    robot, values = concentric_tubes(), joints((0, 0), (first, second))
    slack = min(second - first, -second, first + 150 - second - 85, second + 85)
    if slack >= 0:
        check_concentric_tube_configuration(robot, values)
    elif slack < -1e-6:
        with pytest.raises(BadInput):
            check_concentric_tube_configuration(robot, values)


def test_ends_that_are_rounded_apart_stand_at_one_place():
    """150 - 86.4 is less than 85 - 21.4 by rounding."""
    assert 150 - 86.4 < 85 - 21.4
    check_concentric_tube_configuration(concentric_tubes(), joints((0, 0), (-86.4, -21.4)))


def test_limits_are_kept():
    robot = concentric_tubes(
        translation_limits_mm=np.array([[-50.0, 0], [-30, 0]]),
        rotation_limits_rad=np.array([[-np.inf, np.inf], [-1.0, 1.0]]),
    )
    check_concentric_tube_configuration(robot, joints((9.0, 1.0), (-50.0, -30.0)))
    with pytest.raises(BadInput, match=r"translations_mm\[0\] = -51 mm"):
        check_concentric_tube_configuration(robot, joints((0.0, 0.0), (-51.0, -30.0)))
    with pytest.raises(BadInput, match=r"rotations_rad\[1\] = -1.1 rad"):
        check_concentric_tube_configuration(robot, joints((0.0, -1.1), (-50.0, -30.0)))


def test_grasps_are_told_from_the_tip_or_the_entry():
    assert grasp_arc_mm(Snare(1, 10.0), 200.0) == 190.0
    assert grasp_arc_mm(Snare(1, 10.0, "entry"), 200.0) == 10.0


def load(arc: float) -> PointLoad:
    return PointLoad(arc, np.zeros(3), np.zeros(3))


@pytest.mark.parametrize(
    ("values", "told"),
    [
        (poses((200.0, 105.0)), "lengths: 2"),
        (poses((200.0, 0.0, 105.0)), r"lengths_mm\[1\] = 0 mm"),
        (poses((200.0, np.nan, 105.0)), r"lengths_mm\[1\]"),
        (poses((120.0, 105.0, 105.0)), "needle 1 grasps the tool 120 mm from its tip"),
        (poses(loads=(load(201.0),)), r"loads\[0\].arc_length_mm = 201 mm"),
    ],
)
def test_lengths_grasps_and_loads_off_the_tool_are_refused(values, told):
    check_crisp_configuration(crisp(), poses(loads=(load(200.0), load(0.0))))
    with pytest.raises(BadInput, match=told):
        check_crisp_configuration(crisp(), values)


def test_a_snare_shorter_than_the_straight_way_is_refused_with_what_is_missing():
    """From (100, 0, 80) to the grasp at 80 mm: 128.06 mm apart, 80 of them along the tool."""
    short = float(np.hypot(100, 80) - 80)
    check_crisp_configuration(crisp(), poses((200.0, short + 1e-6, 105.0)))
    with pytest.raises(BadInput, match=r"128\.062 mm apart") as caught:
        check_crisp_configuration(crisp(), poses((200.0, short - 1, 105.0)))
    assert "needle 1 47.0625 mm" in str(caught.value)
    assert "at least 1 mm longer" in str(caught.value)


def test_two_snares_too_short_to_meet_over_the_tool_are_refused():
    """Each alone reaches the tool, which may go to either; both at once do not."""
    entries = np.array([[0.0, 0, 0], [150, 0, 0], [-150, 0, 0]])
    setup = crisp(
        entry_points_patient_mm=entries,
        snares=(Snare(1, 100.0, "entry"), Snare(2, 120.0, "entry")),
    )
    check_crisp_configuration(setup, poses((200.0, 150.0, 131.0)))
    with pytest.raises(BadInput, match=r"needles 1 and 2 are 300 mm apart.*needle 2 129 mm"):
        check_crisp_configuration(setup, poses((200.0, 150.0, 129.0)))


@settings(max_examples=200)
@given(st.integers(0, 2**32 - 1))
def test_what_a_bent_robot_reaches_is_never_refused(seed):
    """Entry points are laid at the ends of random broken lines, which are longer than straight."""
    rng = np.random.default_rng(seed)
    lengths = rng.uniform(20, 200, 3)
    grasps = rng.uniform(0.05, 1, 2) * lengths[0]
    steps = rng.normal(size=(400, 3))
    tool = np.cumsum(steps / np.linalg.norm(steps, axis=1)[:, None] * lengths[0] / 400, 0)
    entries = [np.zeros(3)]
    for grasp, length in zip(grasps, lengths[1:], strict=True):
        held = tool[max(int(grasp / lengths[0] * 400) - 1, 0)]
        way = rng.normal(size=3)
        entries.append(held + way / np.linalg.norm(way) * length * rng.uniform(0.3, 0.999))
    points = np.array(entries)
    apart = np.linalg.norm(points[:, None] - points[None], axis=-1)[np.triu_indices(3, 1)]
    if apart.min() < 1.27:
        return
    snares = tuple(Snare(k + 1, float(grasps[k]), "entry") for k in range(2))
    setup = crisp(entry_points_patient_mm=points, snares=snares)
    check_crisp_configuration(setup, poses(tuple(lengths)))


def test_a_tool_alone_has_nothing_to_reach():
    alone = crisp(needles=(needle(),), snares=(), entry_points_patient_mm=np.zeros((1, 3)))
    check_crisp_configuration(alone, poses((10.0,)))
