"""What a reader chooses in a page of plans: a goal, a step, what colours tell."""

import pytest

from nodes.geometry.meshes import Surfaces
from nodes.reporting.show_plans import show_plans
from nodes.reporting.show_visibility import show_visibility
from tests.nodes.reporting import made_plans

CANVAS, SECOND = ".viewer3d canvas >> nth=0", ".viewer3d canvas >> nth=1"
SMALL = {"pictures": 3, "pixels": 48, "cell_mm": 4.0}


@pytest.fixture(scope="module")
def shared_view(open_shared_page, case_page, defaults):
    distance = made_plans.make_distance()
    nothing = Surfaces((), made_plans.ORIGIN)
    plans = show_plans(made_plans.make_plans(), distance, nothing, defaults("show_plans", **SMALL))
    sets = made_plans.make_sets("one", "two")
    seen = show_visibility(
        sets, made_plans.make_trees("one", "two"), distance, made_plans.make_table(sets),
        defaults("show_visibility", cell_mm=4.0),
    )  # fmt: skip
    page = open_shared_page(case_page(plans, seen))
    page.wait_until_ready()
    return page


@pytest.fixture
def view(shared_view):
    """The page with the first goal chosen, at the motion's end."""
    choose(shared_view, ".choose", "nodule: plan, passed")
    return shared_view


def choose(page, place, text):
    page.locator(f"{place} select").first.select_option(text)
    page.settle()


def go(page, step):
    page.locator(".player input").first.evaluate(
        f"e => {{ e.value = {step}; e.dispatchEvent(new Event('input')); }}"
    )
    page.settle()


def test_the_page_shows_itself_without_errors(view):
    view.assert_quiet()
    assert view.locator("[data-state=ready]").count() == 2


def test_a_goal_shows_its_verdict_and_hides_all_others(view):
    assert view.locator(".verdict.passed").is_visible()
    assert not view.locator(".verdict.refused").is_visible()
    choose(view, ".choose", "rib: refused, no plan")
    assert view.locator(".verdict.refused").is_visible()
    assert not view.locator(".verdict.passed").is_visible()


def test_a_goal_without_motion_has_no_player(view):
    assert view.locator(".player").first.is_visible()
    choose(view, ".choose", "apex: no motion")
    assert not view.locator(".player").first.is_visible()
    assert not view.locator(".camera").first.is_visible()


def test_the_slider_moves_the_robot_and_says_where_it_is(view, differ):
    end = view.picture(CANVAS)
    assert view.locator(".player output").first.text_content().startswith("step 30 of 30")
    go(view, 0)
    assert view.locator(".player output").first.text_content().startswith("step 1 of 30")
    assert differ(end, view.picture(CANVAS)) > 0.001
    go(view, 29)
    assert differ(end, view.picture(CANVAS)) < 0.0001


def test_the_cameras_picture_follows_the_slider(view):
    go(view, 0)
    assert view.locator(".camera figcaption").text_content().startswith("step 1 of 30")
    go(view, 28)
    assert view.locator(".camera figcaption").text_content().startswith("step 1")
    go(view, 29)
    assert view.locator(".camera figcaption").text_content().startswith("step 30 of 30")
    assert view.locator(".camera img").evaluate("e => e.naturalWidth") == 48


def test_lines_in_charts_stand_at_the_step(view):
    def places():
        return view.locator("[data-choice='0'] .now").evaluate_all(
            "marks => marks.map(mark => mark.getBoundingClientRect().x)"
        )

    end = places()
    go(view, 0)
    start = places()
    assert len(start) == 2 and all(b - a > 100 for a, b in zip(start, end, strict=True))


def test_play_runs_to_the_end_and_stops(view):
    button = view.locator(".player button").first
    button.click()
    assert button.text_content() == "Stop"
    view.wait_for_function("() => document.querySelector('.player button').textContent === 'Play'")
    assert view.locator(".player output").first.text_content().startswith("step 30 of 30")


def test_colours_change_with_what_they_show(view, differ):
    before = view.picture(SECOND)
    key = view.locator(".paints li").all_text_contents()
    choose(view, ".paints", "first seen by one")
    assert differ(before, view.picture(SECOND)) > 0.01
    assert view.locator(".paints li").all_text_contents() != key
    choose(view, ".paints", "seen by all together")
    assert differ(before, view.picture(SECOND)) < 0.0001
