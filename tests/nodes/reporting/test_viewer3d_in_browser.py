"""The 3-D viewer in a real browser: not blank, and doing what its controls say."""

from dataclasses import replace

import numpy as np
import pytest

from nodes.geometry.sites import Sites
from nodes.reporting.embedding import add_array, embed_json
from nodes.reporting.scene import build_scene
from nodes.reporting.show_sites import show_sites
from nodes.reporting.show_surfaces import show_surfaces

CANVAS = ".viewer3d canvas"


@pytest.fixture(scope="module")
def shared_view(open_shared_page, case_page, balls, defaults):
    parameters = defaults("show_surfaces", opacities={"body": 0.2})
    page = open_shared_page(case_page(show_surfaces(balls, parameters)))
    page.wait_until_ready()
    return page


RESET = """() => {
    const [opacities, boxes] = ["range", "checkbox"].map(
        kind => document.querySelectorAll(`.part input[type=${kind}]`));
    boxes.forEach(box => { if (!box.checked) box.click(); });
    opacities.forEach(input => {
        input.value = input.defaultValue;
        input.dispatchEvent(new Event("input"));
    });
    document.querySelector(".views button:last-child").click();
    document.activeElement.blur();
    window.scrollTo(0, 0);
}"""


@pytest.fixture
def view(shared_view):
    """A page with the three balls in 3-D, as it was when it was opened."""
    shared_view.evaluate(RESET)
    shared_view.settle()
    return shared_view


def is_pink(picture):
    """Return where a picture of whole numbers has the lung's colour: red over green, some blue."""
    red, green, blue = picture[..., 0], picture[..., 1], picture[..., 2]
    return (red > green + 40) & (blue > green)


def test_3d_canvas_is_not_blank(view):
    picture = view.picture(CANVAS)
    background = picture[3, 3].astype(int)
    shown = np.abs(picture.astype(int) - background).max(axis=2) > 12
    assert 0.1 < shown.mean() < 0.9
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 100


@pytest.mark.parametrize("part", ["body", "left lung", "bone"])
def test_hiding_a_part_changes_the_picture_and_showing_it_restores_it(view, part, differ):
    before = view.picture(CANVAS)
    box = view.locator(".viewer3d .part", has_text=part).locator("input[type=checkbox]")
    box.uncheck()
    view.settle()
    assert differ(before, view.picture(CANVAS)) > 0.003
    box.check()
    view.settle()
    assert differ(before, view.picture(CANVAS)) < 0.001


def test_opacity_reveals_what_lies_inside(view):
    def pink():
        picture = view.picture(CANVAS).astype(int)
        return int(is_pink(picture).sum())

    opacity = view.locator(".viewer3d .part", has_text="body").locator("input[type=range]")
    clear = pink()
    opacity.evaluate("e => { e.value = 1; e.dispatchEvent(new Event('input')); }")
    view.settle()
    assert clear > 2000 and pink() < clear / 10


def side_of_lung(picture):
    """Return the mean column and row of the pink lung, from the middle of the picture."""
    rows, columns = np.nonzero(is_pink(picture.astype(int)))
    return columns.mean() - picture.shape[1] / 2, rows.mean() - picture.shape[0] / 2


@pytest.mark.parametrize(("name", "sign"), [("A", 1), ("P", -1), ("S", 1), ("I", 1)])
def test_views_put_the_patients_left_where_it_belongs(view, name, sign):
    view.locator(".viewer3d .part", has_text="body").locator("input[type=checkbox]").uncheck()
    view.locator(".views button", has_text=name).first.click()
    view.settle()
    across, _ = side_of_lung(view.picture(CANVAS))
    assert across * sign > 40
    place = {
        key: view.evaluate(
            f"(() => {{ const l = [...document.querySelectorAll('.axes span')]"
            f".find(e => e.textContent === '{key}').getBoundingClientRect(); return l.x; }})()"
        )
        for key in "LR"
    }
    assert (place["L"] - place["R"]) * sign > 100


def test_view_from_the_left_hides_the_right_behind(view):
    view.locator(".viewer3d .part", has_text="body").locator("input[type=checkbox]").uncheck()
    view.locator(".views button", has_text="L").first.click()
    view.settle()
    across, over = side_of_lung(view.picture(CANVAS))
    assert abs(across) < 10 and over < 0  # the lung ball lies above the middle


def test_dragging_turns_and_reset_restores(view, differ):
    before = view.picture(CANVAS)
    box = view.locator(CANVAS).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    view.mouse.move(x, y)
    view.mouse.down()
    view.mouse.move(x + 150, y + 40, steps=4)
    view.mouse.up()
    view.settle()
    assert differ(before, view.picture(CANVAS)) > 0.02
    view.locator(".views button", has_text="Reset").click()
    view.settle()
    assert differ(before, view.picture(CANVAS)) < 0.001


@pytest.mark.parametrize("key", ["ArrowLeft", "ArrowUp", "+", "-"])
def test_keys_turn_and_zoom(view, key, differ):
    before = view.picture(CANVAS)
    view.locator(CANVAS).focus()
    for _ in range(3):
        view.keyboard.press(key)
    view.settle()
    assert differ(before, view.picture(CANVAS)) > 0.01


def test_the_wheel_scrolls_the_page_until_the_view_is_clicked(view):
    def distance():
        return view.evaluate(
            "(() => { const v = document.querySelector('.viewer3d').viewer;"
            " return v.camera.position.distanceTo(v.controls.target); })()"
        )

    view.locator(CANVAS).scroll_into_view_if_needed()
    box = view.locator(CANVAS).bounding_box()
    view.mouse.move(box["x"] + 100, box["y"] + 100)
    far = distance()
    view.mouse.wheel(0, -120)
    view.settle()
    assert distance() == far
    box = view.locator(CANVAS).bounding_box()
    view.mouse.click(box["x"] + 100, box["y"] + 100)
    view.mouse.wheel(0, -120)
    view.settle()
    assert distance() < far


def test_meshes_wear_colours_of_vertices_and_of_triangles(show, balls, defaults):
    parameters = defaults("show_surfaces")
    section = show_surfaces(balls, parameters)
    scene = build_scene(replace(balls, meshes=balls.meshes[1:]), parameters)
    for item, key, (_, mesh), colour in zip(
        scene["objects"],
        ("vertex_colours", "triangle_colours"),
        balls.meshes[1:],
        ((255, 0, 0), (0, 255, 0)),
        strict=True,
    ):
        count = len(mesh.vertices_patient_mm if key == "vertex_colours" else mesh.triangles)
        item[key] = add_array(scene["buffers"], np.tile(colour, (count, 1)), "uint8")
    old = embed_json(build_scene(balls, parameters))
    page = show(replace(section, html=section.html.replace(old, embed_json(scene))))
    page.assert_quiet()
    picture = page.picture(CANVAS).astype(int)
    for channel in (0, 1):
        others = np.delete(picture, channel, axis=2).max(axis=2)
        assert (picture[..., channel] > others + 60).sum() > 500


def test_a_kind_that_the_viewer_does_not_know_is_said(show, balls, defaults):
    section = show_surfaces(balls, defaults("show_surfaces"))
    odd = section.html.replace('"kind":"mesh"', '"kind":"smoke"', 1)
    page = show(replace(section, html=odd))
    assert "kind smoke" in page.locator(".failure").text_content()


@pytest.mark.parametrize("side", ["A", "P", "S"])
def test_a_name_stands_where_its_mark_is_seen(show, balls, defaults, side):
    points = np.array([[60.0, -120.0, 70.0], [-80.0, 110.0, -60.0]])
    sites = Sites((), np.zeros((0, 4, 4)), ("one", "other"), points)
    page = show(show_sites(balls, sites, defaults("show_sites", ball_radius_mm=8.0)))
    for part in ("body", "left lung", "bone"):
        page.locator(".part", has_text=part).locator("input[type=checkbox]").uncheck()
    page.locator(".views button", has_text=side).first.click()
    page.settle()
    picture = page.picture(CANVAS).astype(int)
    rows, columns = np.nonzero(picture[..., 0] > picture[..., 1] + 60)
    stage = page.locator(".viewer3d .stage").bounding_box()
    for name in ("one", "other"):
        tag = page.locator(".tags span", has_text=name).first.bounding_box()
        x, y = tag["x"] - 8 - stage["x"], tag["y"] + tag["height"] / 2 - stage["y"]
        near = np.hypot(rows - y, columns - x) < 60
        assert near.sum() > 100
        assert columns[near].mean() == pytest.approx(x, abs=4)
        assert rows[near].mean() == pytest.approx(y, abs=4)


def test_names_of_places_close_together_do_not_cover_each_other(show, balls, defaults):
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]])
    sites = Sites((), np.zeros((0, 4, 4)), tuple(f"target_{n}" for n in range(4)), points)
    page = show(show_sites(balls, sites, defaults("show_sites")))
    boxes = [page.locator(".tags span").nth(n).bounding_box() for n in range(4)]
    rows = sorted(box["y"] for box in boxes)
    assert all(np.diff(rows) > 13) and rows[-1] - rows[0] < 80


def test_names_are_hidden_with_their_marks(show, balls, defaults):
    sites = Sites((), np.zeros((0, 4, 4)), ("target",), np.zeros((1, 3)))
    page = show(show_sites(balls, sites, defaults("show_sites")))
    tag = page.locator(".tags span")
    assert tag.is_visible()
    page.locator(".part", has_text="points").locator("input[type=checkbox]").uncheck()
    page.settle()
    assert not tag.is_visible()


def test_the_extent_is_that_of_the_anatomy_and_not_of_marks(show, balls, defaults):
    sites = Sites((), np.zeros((0, 4, 4)), ("far",), np.array([[900.0, 0, 0]]))
    page = show(show_sites(balls, sites, defaults("show_sites")))
    assert "200 mm wide, 200 mm deep, 200 mm high" in page.locator(".extent").text_content()


def test_a_mark_inside_an_opaque_organ_shines_through(show, balls, defaults):
    sites = Sites((), np.zeros((0, 4, 4)), ("target",), np.array([[45.0, 0, 10]]))
    page = show(show_sites(balls, sites, defaults("show_sites", opacities={}, ball_radius_mm=20)))
    box = page.locator(".part", has_text="points").locator("input[type=checkbox]")
    seen = page.picture(CANVAS).astype(int)
    box.uncheck()
    page.settle()
    hidden = page.picture(CANVAS).astype(int)
    assert (np.abs(seen - hidden).max(axis=2) > 30).sum() > 500
