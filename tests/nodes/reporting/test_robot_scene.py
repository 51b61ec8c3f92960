import numpy as np
import pytest

from nodes.reporting.robot_scene import (
    RobotSteps,
    choose_steps,
    choose_thickness,
    draw_robot,
    make_cone,
    take_start,
    tell_thickness,
)
from tests.nodes.reporting import made_plans


@pytest.fixture(scope="module")
def shown(defaults):
    motion = made_plans.make_motion(4)
    steps = RobotSteps(
        made_plans.make_setup().setup, motion.orientations, motion.lengths_mm, motion.wrenches,
        motion.patient_from_camera,
    )  # fmt: skip
    parts = draw_robot(steps, 2.0, 7, defaults("show_plans", outside_mm=30.0))
    return {part.name: part for part in parts}, motion


def test_unbent_needles_are_drawn_straight_from_their_entries_to_their_tips(shown):
    parts, motion = shown
    for place, name in enumerate(("camera tube", "snare")):
        curves = parts[name].points_patient_mm
        entry = made_plans.make_setup().setup.entry_points_patient_mm[place]
        tip = entry + motion.lengths_mm[:, place, None] * motion.orientations[:, place, :, 2]
        assert curves[:, 0, 0] == pytest.approx(np.tile(entry, (4, 1)), abs=1e-6)
        assert curves[:, 0, -1] == pytest.approx(tip, abs=1e-6)


def test_sheaths_go_straight_back_from_the_entries(shown):
    parts, motion = shown
    sheaths = parts["sheaths"].points_patient_mm
    back = (sheaths[:, :, 1] - sheaths[:, :, 0]) / 30
    assert back == pytest.approx(motion.orientations[..., 2], abs=1e-9)


def test_all_parts_belong_to_the_choice_and_needles_have_their_radius(shown):
    parts, _ = shown
    assert {part.choice for part in parts.values()} == {7}
    assert parts["camera tube"].radius_mm == pytest.approx(1.02)


def test_the_start_of_a_tree_is_its_root():
    tree = made_plans.make_tree()
    start = take_start(tree)
    assert len(start.lengths_mm) == 1
    assert start.patient_from_camera[0, :3, 2] == pytest.approx(tree.views[0])
    assert start.patient_from_camera[0, :3, 3] == pytest.approx(tree.cameras_patient_mm[0])


@pytest.mark.parametrize("angle", [40.0, 90.0, 170.0])
def test_the_cone_opens_by_the_field_of_view(angle):
    points = make_cone(angle, 25.0).vertices_patient_mm
    length = np.linalg.norm(points, axis=1)
    far = points[length > 1]
    assert length.max() == pytest.approx(25, abs=1e-4)
    widest = np.degrees(np.arctan2(np.hypot(far[:, 0], far[:, 1]), far[:, 2])).max()
    assert widest == pytest.approx(angle / 2, abs=1e-3)


def test_needles_are_drawn_thicker_only_where_they_would_not_be_seen():
    setups = (made_plans.make_setup().setup,)
    points = np.array([[0.0, 0, 0], [300, 0, 400]])
    assert choose_thickness(points, setups, 0.00204) == pytest.approx(2.0)
    assert choose_thickness(points, setups, 0.0005) == 1.0
    assert "2.0 times" in tell_thickness(2.0) and tell_thickness(1.0) == ""


@pytest.mark.parametrize(("count", "most"), [(1, 5), (4, 9), (100, 7), (2, 2)])
def test_steps_are_chosen_in_order_with_both_ends(count, most):
    chosen = choose_steps(count, most)
    assert chosen[0] == 0 and chosen[-1] == count - 1
    assert chosen == sorted(set(chosen)) and len(chosen) == min(count, most)
