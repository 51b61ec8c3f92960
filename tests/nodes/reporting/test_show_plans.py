import re
from base64 import b64decode
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from nodes.geometry.origin import Origin
from nodes.planning.artefacts import CheckedPlans
from nodes.reporting.show_plans import show_plans
from tests.nodes.reporting import made_plans
from tests.nodes.reporting.test_show_sites import points_of, scene_of

SMALL = {"pictures": 3, "pixels": 48, "cell_mm": 4.0}


@pytest.fixture(scope="module")
def show_plan(balls, defaults):
    """Give `show_plan(*plans, ...)`: the section of some plans in the made cavity."""
    distance = made_plans.make_distance()

    def show_plan(*plans, **changes):
        checked = CheckedPlans(plans, made_plans.ORIGIN)
        return show_plans(checked, distance, balls, defaults("show_plans", **(SMALL | changes)))

    return show_plan


@pytest.fixture(scope="module")
def section(show_plan):
    return show_plan(*made_plans.make_plans().plans)


def test_a_refused_motion_is_never_called_a_plan(show_plan):
    refused = made_plans.refuse(made_plans.make_plan())
    section = show_plan(refused)
    words = re.sub(r"<script.*?</script>|<[^>]*>", " ", section.html, flags=re.S)
    assert "Refused by the independent check" in words and "step 12 touches" in words
    assert [
        said for said in re.findall(r"[^.]*\bplan\b[^.]*", words) if "no plan" not in said
    ] == []
    assert "refused by the independent check" in section.warnings[0]


def test_the_verdict_stands_before_the_3d_view(section):
    assert 0 < section.html.index('class="verdict passed"') < section.html.index("viewer3d")
    assert "No node of the tree sees it." in section.html


def test_each_goal_has_a_choice_that_tells_its_verdict(section):
    names = [choice["name"] for choice in scene_of(section)["choices"]]
    assert names == ["nodule: plan, passed", "rib: refused, no plan", "apex: no motion"]
    verdicts = re.findall(r'class="verdict (\w+)" data-choice="(\d)"', section.html)
    assert verdicts == [("passed", "0"), ("refused", "1"), ("none", "2")]


def test_the_robot_moves_in_as_many_steps_as_are_told(section):
    scene = scene_of(section)
    steps = scene["choices"][0]["steps"]
    tool = next(item for item in scene["objects"] if item["name"] == "camera tube")
    stored = np.frombuffer(b64decode(scene["buffers"][tool["points"]["buffer"]]), "<u2")
    assert len(stored) == 3 * len(steps) * tool["points_each"] * tool["curves"]
    assert steps[0].startswith("step 1 of 30") and steps[-1].startswith("step 30 of 30")
    assert scene["choices"][2]["steps"] == []


def test_long_motions_are_thinned_with_both_ends(show_plan):
    section = show_plan(made_plans.make_plan(), most_steps=8)
    steps = scene_of(section)["choices"][0]["steps"]
    assert len(steps) == 8 and steps[-1].startswith("step 30 of 30")
    assert max(map(int, re.findall(r'data-step="(\d+)"', section.html))) == 7


def test_the_goal_is_marked_where_it_is(section):
    middle = points_of(scene_of(section), "goal").mean(axis=0)
    assert middle == pytest.approx([40, 2, 0], abs=0.05)


def test_camera_pictures_are_small_webp_along_the_motion(section):
    sources = re.findall(r'src="data:image/webp;base64,([^"]*)"', section.html)
    assert len(sources) == 6  # three each of the two motions
    assert Image.open(BytesIO(b64decode(sources[0]))).size == (48, 48)
    captions = re.findall(r"<figcaption>(step[^<]*)<", section.html)
    assert captions[0] == "step 1 of 30: goal in the cone, 30 mm away"


def test_curves_follow_the_motion_and_mark_where_it_fails(section):
    assert section.html.count('class="now"') == 4
    assert ">touches<" in section.html and ">unstable<" in section.html


def test_only_the_first_motions_are_drawn_but_all_are_in_the_table(show_plan):
    section = show_plan(*made_plans.make_plans().plans, most_motions=1)
    assert len(scene_of(section)["choices"]) == 1
    assert "The first 1 of 3 are drawn below." in section.html
    assert all(goal in section.html for goal in ("nodule", "rib", "apex"))


def test_no_goal_is_said_and_needs_no_script(show_plan):
    section = show_plan()
    assert "There is no goal." in section.html and section.scripts == ()


def test_what_is_simulated_and_noticed_is_said(section):
    assert "simulated: a made cavity" in section.warnings
    assert "Its walls are an ellipsoid." in section.warnings
    assert "not measured" in section.html


def test_names_of_goals_are_escaped(show_plan, hostile):
    plan = made_plans.make_plan(hostile)
    section = show_plan(plan, made_plans.refuse(plan, hostile), made_plans.lose(plan, hostile))
    outside = re.sub(r'<script type="application/json">.*?</script>', "", section.html, flags=re.S)
    assert "<script>" not in outside and "<b " not in section.html


def test_many_cells_of_a_goal_are_marked_as_seen(show_plan):
    plan = made_plans.make_plan()
    cells = made_plans.make_cells()[:5]
    wide = replace(plan, proposed=replace(plan.proposed, cells=cells))
    dots = points_of(scene_of(show_plan(wide)), "seen of the goal")
    affine = made_plans.PATIENT_FROM_INDEX
    places = cells * affine[0, 0] + affine[:3, 3]
    assert dots.reshape(5, -1, 3).mean(axis=1) == pytest.approx(places, abs=0.05)


def test_a_real_patient_is_not_called_simulated(defaults, balls):
    real = CheckedPlans((made_plans.make_plan(),), Origin("a CT"))
    parameters = defaults("show_plans", **SMALL)
    section = show_plans(real, made_plans.make_distance(), balls, parameters)
    assert not any(text.startswith("simulated") for text in section.warnings)


def test_several_motions_to_one_region_are_counted(show_plan):
    plan = made_plans.make_plan("pleura")
    names = [one["name"] for one in scene_of(show_plan(plan, plan))["choices"]]
    assert names == ["pleura, motion 1 of 2: plan, passed", "pleura, motion 2 of 2: plan, passed"]


def test_what_the_check_could_not_measure_is_a_dash(show_plan):
    plan = made_plans.refuse(made_plans.make_plan())
    unknown = np.full(30, np.nan)
    section = show_plan(replace(plan, clearances_mm=unknown, margins=unknown))
    assert "nan" not in re.sub(r"<script.*?</script>|src=\"[^\"]*\"", "", section.html, flags=re.S)
    assert "\N{EN DASH}" in section.html
    assert scene_of(section)["choices"][0]["steps"][0] == "step 1 of 30"
