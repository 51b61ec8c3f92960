from dataclasses import replace

import numpy as np
import pytest

from nodes.geometry.origin import Origin
from nodes.mechanics.shapes import Figure, RobotShape, Rod
from nodes.reporting.show_shape import show_shape
from tests.nodes.reporting.test_show_sites import points_of, scene_of


@pytest.fixture
def shape() -> RobotShape:
    """A straight tool along z with one grasp and a force of 0.1 N along x at its tip."""
    along = np.linspace(0, 100, 11)
    points = np.stack([0 * along, 0 * along, along], axis=1)
    tip = np.eye(4)
    tip[:3, 3] = [0, 0, 100]
    return RobotShape(
        kind="CRISP",
        status="solved",
        reason="",
        given=(Figure("length of tool", 100.0, "mm", "nitinol, from [0, 0, 0]"),),
        rods=(Rod("tool", along, points, np.tile([0.0, 0, 1], (11, 1)), 0.6),),
        patient_from_tip=tip,
        joints_patient_mm=np.array([[0.0, 0, 90]]),
        loads=np.array([[0, 0, 100, 0.1, 0, 0]]),
        figures=(Figure("residual", 1.25e-12, "mm", "how far the grasps are apart"),),
        origin=Origin("a test", notices=("computed, not measured",)),
    )


def test_rods_stand_at_their_place_with_their_radius(shape, defaults):
    points = points_of(scene_of(show_shape(shape, defaults("show_shape"))), "tool")
    assert points[:, 2].min() == pytest.approx(0, abs=0.01)
    assert points[:, 2].max() == pytest.approx(100, abs=0.01)
    assert np.linalg.norm(points[:, :2], axis=1).max() == pytest.approx(0.6, abs=0.01)


def test_the_tip_arrow_and_the_force_run_where_they_should(shape, defaults):
    parameters = defaults("show_shape", axis_length_mm=15, force_length_mm_per_n=200)
    scene = scene_of(show_shape(shape, parameters))
    assert points_of(scene, "tip tangent")[:, 2].max() == pytest.approx(115, abs=0.01)
    assert points_of(scene, "forces")[:, 0].max() == pytest.approx(20, abs=0.01)
    forces = next(item for item in scene["objects"] if item["name"] == "forces")
    assert forces["tags"][0]["text"] == "0.1 N"


def test_figures_stand_in_a_table_with_unit_and_meaning(shape, defaults):
    html = show_shape(shape, defaults("show_shape")).html
    assert "100 mm" in html and "nitinol, from [0, 0, 0]" in html
    assert "1.25e-12 mm" in html and "how far the grasps are apart" in html


def test_a_shape_that_is_not_solved_is_a_warning_and_shows_no_rods(shape, defaults):
    none = replace(
        shape, status="no solution", reason="snare 1 is 3 mm short", rods=(),
        patient_from_tip=np.empty((0, 0)), joints_patient_mm=np.empty((0, 3)),
    )  # fmt: skip
    section = show_shape(none, defaults("show_shape"))
    assert section.warnings[0] == "no solution: snare 1 is 3 mm short"
    assert "viewer3d" not in section.html and section.scripts == ()


def test_an_unstable_shape_is_shown_with_its_warning(shape, defaults):
    section = show_shape(
        replace(shape, status="unstable", reason="it buckles"), defaults("show_shape")
    )
    assert section.warnings[0] == "unstable: it buckles" and "viewer3d" in section.html


def test_tubes_too_thin_to_be_seen_are_drawn_thicker_and_the_page_says_so(shape, defaults):
    section = show_shape(shape, defaults("show_shape", least_radius_share=0.012))
    points = points_of(scene_of(section), "tool")
    assert np.linalg.norm(points[:, :2], axis=1).max() == pytest.approx(1.2, abs=0.01)
    assert "2.0 times as thick" in section.html
    plain = show_shape(shape, defaults("show_shape", least_radius_share=0.001))
    assert "times as thick" not in plain.html
