"""The slice viewer in a real browser: exact labels, true places, and working controls."""

import re

import numpy as np
import pandas
import pytest

from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.origin import Origin
from nodes.reporting.show_slices import show_slices
from nodes.reporting.show_table import show_table

AXIAL = ".pane[data-plane=axial]"


@pytest.fixture(scope="module")
def box_page(open_shared_page, case_page, box_with_ball, defaults):
    section = show_slices(*box_with_ball, defaults("show_slices", hidden_labels=[]))
    return open_shared_page(case_page(section))


@pytest.fixture
def slices(box_page):
    """A page with the box and its ball in slices, all labels on, as it was when it was opened."""
    box_page.reload()
    box_page.wait_until_ready()
    return box_page


def read_pane(page, plane):
    """Return what a canvas holds, as (rows, columns, 3) uint8."""
    shape, data = page.evaluate(
        f"(() => {{ const c = document.querySelector('.pane[data-plane={plane}] canvas');"
        " const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
        " return [[c.height, c.width], Array.from(d)]; })()"
    )
    return np.array(data, np.uint8).reshape(*shape, 4)[..., :3]


def go_to(page, i, j, k):
    page.evaluate(
        f"(() => {{ const v = document.querySelector('.slices').viewer;"
        f" [{i}, {j}, {k}].forEach((n, axis) => v.moveTo(axis, n)); }})()"
    )
    page.settle()


def test_every_label_is_decoded_exactly(slices, box_with_ball):
    decoded = slices.evaluate("Array.from(document.querySelector('.slices').viewer.voxels.labels)")
    labels = np.array(decoded, np.uint8).reshape(box_with_ball[1].voxels.shape, order="F")
    assert np.array_equal(labels, box_with_ball[1].voxels)


def test_255_labels_are_decoded_exactly(show, box_with_ball, defaults):
    volume, _ = box_with_ball
    voxels = (np.arange(volume.voxels.size) % 256).astype(np.uint8).reshape(volume.voxels.shape)
    names = tuple(f"part_{n}" for n in range(255))
    label_map = LabelMap(voxels, volume.patient_from_index, names, Origin("stripes"))
    page = show(show_slices(volume, label_map, defaults("show_slices")))
    decoded = page.evaluate("Array.from(document.querySelector('.slices').viewer.voxels.labels)")
    assert np.array_equal(np.array(decoded).reshape(voxels.shape, order="F"), voxels)


def test_values_are_decoded_nearly(slices, box_with_ball):
    decoded = slices.evaluate(
        "(() => { const v = document.querySelector('.slices').viewer;"
        " return Array.from(v.voxels.greys, g => v.voxels.values[g]); })()"
    )
    hu = box_with_ball[0].voxels
    shown = np.array(decoded).reshape(hu.shape, order="F")
    assert abs(np.median(shown[hu == 40]) - 40) < 8
    assert abs(np.median(shown[hu == -1000]) + 1000) < 30
    assert abs(np.median(shown[hu == 900]) - 900) < 60


@pytest.mark.parametrize(
    ("plane", "right", "low"),
    [("axial", True, True), ("coronal", True, False), ("sagittal", True, False)],
)
def test_the_ball_stands_where_a_radiologist_expects_it(slices, plane, right, low):
    go_to(slices, 33, 27, 13)  # left, posterior and superior of the middle
    for name in ("body", "bone"):
        slices.locator(".slices .part", has_text=name).locator("input[type=checkbox]").uncheck()
    slices.locator(".windows button", has_text="bone").click()
    slices.settle()
    picture = read_pane(slices, plane)[..., 0].astype(float)
    rows, columns = np.nonzero(picture > 160)
    assert bool(columns.mean() > picture.shape[1] / 2) is right
    assert bool(rows.mean() > picture.shape[0] / 2) is low
    letters = slices.evaluate(
        f"[...document.querySelectorAll('.pane[data-plane={plane}] .letter')]"
        ".map(e => [e.className.split(' ')[1], e.textContent])"
    )
    expected = {"axial": "RLAP", "coronal": "RLSI", "sagittal": "APSI"}[plane]
    assert [text for _, text in letters] == list(expected)
    assert [side for side, _ in letters] == ["left", "right", "top", "bottom"]


def test_slider_wheel_and_keys_change_the_slice(slices, differ):
    def number():
        slices.settle()
        return int(slices.locator(AXIAL).get_attribute("data-slice"))

    go_to(slices, 24, 20, 10)
    before = read_pane(slices, "axial")
    slices.locator(f"{AXIAL} input").evaluate(
        "e => { e.value = 13; e.dispatchEvent(new Event('input')); }"
    )
    assert number() == 13
    assert differ(before, read_pane(slices, "axial")) > 0.01
    slices.locator(f"{AXIAL} .frame").focus()
    for key, expected in (
        ("ArrowUp", 14),
        ("ArrowLeft", 13),
        ("PageDown", 3),
        ("End", 19),
        ("ArrowRight", 19),
        ("Home", 0),
        ("x", 0),
    ):
        slices.keyboard.press(key)
        assert number() == expected
    go_to(slices, 24, 20, 10)
    slices.locator(f"{AXIAL} .frame").hover()
    slices.mouse.wheel(0, 100)
    assert number() == 9  # downwards is towards the feet


def test_a_click_moves_the_other_planes_there(slices):
    go_to(slices, 5, 5, 5)
    slices.locator(f"{AXIAL} canvas").scroll_into_view_if_needed()
    box = slices.locator(f"{AXIAL} canvas").bounding_box()
    slices.mouse.click(box["x"] + box["width"] * 33.5 / 48, box["y"] + box["height"] * 27.5 / 40)
    slices.settle()
    assert slices.evaluate("document.querySelector('.slices').viewer.at") == [33, 27, 5]
    assert slices.locator(".pane[data-plane=sagittal]").get_attribute("data-slice") == "33"


@pytest.fixture(scope="module")
def oblique(open_shared_page, case_page, defaults):
    """A page with an oblique volume of few large voxels, and its label map of four labels."""
    rng = np.random.default_rng(5)
    labels = np.kron(rng.integers(0, 5, (4, 3, 5)), np.ones((5, 6, 4))).astype(np.uint8)
    angle = 0.3
    turn = np.array([[0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    patient_from_index = np.eye(4)
    patient_from_index[:3, :3] = np.stack([turn[0], turn[1], [-1, 0, 0]]) @ np.diag([5, 2, 3])
    patient_from_index[:3, 3] = (31.0, -77.0, 212.0)
    hu = (np.int16([-900, -100, 40, 60, 700])[labels]).astype(np.int16)
    names = ("left_lung", "bone", "effusion", "nodule")
    label_map = LabelMap(labels, patient_from_index, names, Origin("blocks"))
    volume = Volume(hu, patient_from_index, "HU", Origin("blocks"))
    page = open_shared_page(case_page(show_slices(volume, label_map, defaults("show_slices"))))
    page.wait_until_ready()
    return page, label_map


def numbers_in(text):
    return [float(number) for number in re.findall(r"-?\d+\.\d", text)]


def label_at(label_map, place):
    """Return the label's name in words at a place in the patient, from the map itself."""
    index = np.linalg.solve(label_map.patient_from_index, [*place, 1])[:3]
    number = label_map.voxels[tuple(np.rint(index).astype(int))]
    return label_map.names[number - 1].replace("_", " ") if number else "no label"


def hover(page, plane, x, y):
    """Point at shares x and y of a picture's width and height."""
    canvas = page.locator(f".pane[data-plane={plane}] canvas")
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    page.mouse.move(box["x"] + box["width"] * x, box["y"] + box["height"] * y)
    page.settle()


@pytest.mark.parametrize("plane", ["axial", "coronal", "sagittal"])
def test_the_readouts_tell_the_label_maps_own_label_at_their_place(oblique, plane):
    page, label_map = oblique
    for x, y in ((0.1, 0.2), (0.37, 0.81), (0.6, 0.45), (0.93, 0.7)):
        hover(page, plane, x, y)
        place = numbers_in(page.locator(".pointer .place").text_content())
        found, _, away = page.locator(".pointer .found").text_content().rpartition(" · ")
        assert found.endswith(label_at(label_map, place)), (plane, x, y)
        here = numbers_in(page.locator(".cross .place").input_value())
        assert numbers_in(away)[0] == pytest.approx(
            np.linalg.norm(np.subtract(place, here)), abs=0.2
        )
        page.mouse.down()
        page.mouse.up()
        page.settle()
        box = page.locator(".cross .place")
        assert numbers_in(box.input_value()) == place
        assert page.locator(".cross .found").text_content() == found


@pytest.mark.parametrize("width", [1400, 900, 390])
def test_the_picture_stays_under_the_pointer_while_readouts_change(
    show, box_with_ball, defaults, width
):
    page = show(show_slices(*box_with_ball, defaults("show_slices")), width=width)
    canvas = page.locator(f"{AXIAL} canvas")
    canvas.scroll_into_view_if_needed()
    before = canvas.bounding_box()
    for x, y in ((0.01, 0.01), (0.5, 0.5), (0.7, 0.7)):
        hover(page, "axial", x, y)
        assert canvas.bounding_box() == before
    for row in (".cross", ".pointer"):
        outer, inner = (page.locator(row + part).bounding_box() for part in ("", " .found"))
        assert inner["y"] + inner["height"] <= outer["y"] + outer["height"] + 1


def test_the_cross_hair_lies_where_the_picture_shows_it(oblique):
    page, label_map = oblique
    hover(page, "axial", 0.31, 0.64)
    page.mouse.down()
    page.mouse.up()
    page.settle()
    place = np.array(numbers_in(page.locator(".cross .place").input_value()))
    axes = label_map.patient_from_index[:3, :3]
    # In index axes: left is j, posterior is k, superior is i backwards; each from its own edge.
    index = np.linalg.solve(axes, place - label_map.patient_from_index[:3, 3])
    i, j, k = label_map.voxels.shape
    across, down, over = (index[1] + 0.5) / j, (index[2] + 0.5) / k, (i - 0.5 - index[0]) / i
    for plane, x, y in (
        ("axial", across, down),
        ("coronal", across, 1 - over),
        ("sagittal", down, 1 - over),
    ):
        film = page.locator(f".pane[data-plane={plane}] .film").bounding_box()
        upright = page.locator(f".pane[data-plane={plane}] .line.vertical").bounding_box()
        level = page.locator(f".pane[data-plane={plane}] .line.horizontal").bounding_box()
        assert upright["x"] - film["x"] == pytest.approx(x * film["width"], abs=1.5)
        assert level["y"] - film["y"] == pytest.approx(y * film["height"], abs=1.5)


def test_a_place_that_is_typed_is_gone_to_and_nonsense_is_not(slices):
    box = slices.locator(".cross .place")
    go_to(slices, 0, 0, 0)
    for text, expected in (
        ("[18.3, 14.0, 151.2]", "[18.0, 14.0, 152.0]"),
        ("-20 -8.4 1.2e2", "[-20.0, -8.0, 120.0]"),
        ("999, 0, 120", "[-20.0, -8.0, 120.0]"),
        ("here", "[-20.0, -8.0, 120.0]"),
    ):
        box.fill(text)
        box.press("Enter")
        slices.settle()
        assert box.input_value() == expected
    assert slices.evaluate("document.querySelector('.slices').viewer.at") == [14, 16, 5]


def test_a_place_in_a_table_is_gone_to_by_a_click(show, box_with_ball, defaults):
    table = pandas.DataFrame({"tip_x_mm": [18.0], "tip_y_mm": [14.0], "tip_z_mm": [152.0]})
    page = show(
        show_table(table, defaults("show_measures")),
        show_slices(*box_with_ball, defaults("show_slices")),
    )
    page.locator("td.place").click()
    page.settle()
    assert page.evaluate("document.querySelector('.slices').viewer.at") == [33, 27, 13]
    assert page.evaluate("getSelection().toString()") == "[18.0, 14.0, 152.0]"


def test_the_place_is_copied(slices):
    go_to(slices, 33, 27, 13)
    slices.evaluate(
        "() => { window.copied = ''; document.addEventListener('copy', () => "
        "{ const e = document.activeElement;"
        " window.copied = e.value.slice(e.selectionStart, e.selectionEnd); });"
        " navigator.clipboard.writeText = text => { window.written = text;"
        " return Promise.reject(); }; }"
    )
    slices.locator(".copy").click()
    slices.settle()
    assert slices.evaluate("window.written") == "[18.0, 14.0, 152.0]"
    assert slices.evaluate("window.copied") == "[18.0, 14.0, 152.0]"


def test_values_of_averaged_voxels_are_said_to_be(show, box_with_ball, defaults):
    text = show_slices(*box_with_ball, defaults("show_slices", pixels=24)).html
    assert "averaged over 2 x 2 x 1 voxels" in text
    assert "averaged" not in show_slices(*box_with_ball, defaults("show_slices")).html


def test_labels_without_an_image_have_no_window_and_no_value(show, box_with_ball, defaults):
    volume, label_map = box_with_ball
    black = Volume(np.zeros_like(volume.voxels), volume.patient_from_index, "HU", volume.origin)
    page = show(show_slices(black, label_map, defaults("show_slices")))
    go_to(page, 33, 27, 13)
    assert page.locator(".cross .found").text_content() == "bone"
    assert read_pane(page, "axial")[0, 0].tolist() == [0, 0, 0]
    assert not page.locator(".slices .controls").is_visible()
    page.assert_quiet()


def test_level_and_width_are_free(slices):
    def greys():
        slices.settle()
        return read_pane(slices, "axial")[27, 33, 0], read_pane(slices, "axial")[20, 24, 0]

    go_to(slices, 33, 27, 13)
    for name in ("body", "bone"):
        slices.locator(".slices .part", has_text=name).locator("input[type=checkbox]").uncheck()
    for level, width, bone, soft in ((900, 2000, 0.5, 0.07), (0, 200, 1, 0.7), (0, -5, 1, 0.7)):
        slices.locator("input.level").fill(str(level))
        slices.locator("input.width").fill(str(width))
        slices.locator("input.width").press("Enter")
        shown = greys()
        assert shown[0] / 255 == pytest.approx(bone, abs=0.04)
        assert shown[1] / 255 == pytest.approx(soft, abs=0.04)
    assert slices.locator("input.width").input_value() == "200"
    assert slices.locator(".windows [aria-pressed=true]").count() == 0


def test_a_right_drag_changes_level_and_width_and_no_slice(slices):
    at = slices.evaluate("document.querySelector('.slices').viewer.at")
    hover(slices, "axial", 0.3, 0.3)
    slices.mouse.down(button="right")
    hover(slices, "axial", 0.6, 0.7)
    slices.mouse.up(button="right")
    assert float(slices.locator("input.level").input_value()) > 50
    assert float(slices.locator("input.width").input_value()) > 400
    assert slices.evaluate("document.querySelector('.slices').viewer.at") == at


def test_letters_change_window_labels_and_outlines(slices, differ):
    go_to(slices, 33, 27, 13)
    slices.locator(f"{AXIAL} .frame").focus()

    def press(key):
        slices.keyboard.press(key)
        slices.settle()
        return read_pane(slices, "axial")

    filled = read_pane(slices, "axial")
    outlined = press("o")
    assert differ(filled, outlined) > 0.2
    assert np.array_equal(outlined[27, 33], read_pane(slices, "axial")[27, 33])
    assert np.ptp(outlined[27, 33]) == 0 and np.ptp(filled[27, 33]) > 0  # inside the ball: grey
    assert differ(filled, press("o")) == 0
    bare = press("l")
    assert np.ptp(bare.astype(int), axis=2).max() == 0
    assert differ(filled, press("l")) == 0
    press("w")
    assert slices.locator(".windows [aria-pressed=true]").text_content() == "lung"


def test_all_labels_are_faded_and_hidden_together(slices):
    row = slices.locator(".all .part")
    row.locator("input[type=range]").evaluate(
        "e => { e.value = 1; e.dispatchEvent(new Event('input')); }"
    )
    slices.settle()
    shown = read_pane(slices, "axial").reshape(-1, 3).tolist()
    assert {(0xD8, 0xB4, 0x9C), (0xF1, 0xE7, 0xC9)} <= set(map(tuple, shown))
    values = "[...document.querySelectorAll('.parts input[type=range]')].map(e => e.value)"
    assert slices.evaluate(values) == ["1", "1"]
    row.locator("input[type=checkbox]").uncheck()
    slices.settle()
    assert np.ptp(read_pane(slices, "axial").astype(int), axis=2).max() == 0


def test_frames_are_equally_high_and_pictures_have_one_scale(oblique):
    page, _ = oblique
    frames, scales = [], []
    for plane in ("axial", "coronal", "sagittal"):
        pane = f".pane[data-plane={plane}]"
        frames.append(page.locator(f"{pane} .frame").bounding_box()["height"])
        picture = page.locator(f"{pane} canvas").bounding_box()
        bar = page.locator(f"{pane} .scale")
        scales.append(bar.bounding_box()["width"] / float(bar.text_content().split()[0]))
        wide = {"axial": 2 * 18, "coronal": 2 * 18, "sagittal": 3 * 20}[plane]
        assert scales[-1] == pytest.approx(picture["width"] / wide, rel=0.03)
    assert np.ptp(frames) < 1.5 and scales == pytest.approx([scales[0]] * 3, rel=0.03)


def test_a_plane_can_be_enlarged_and_shrunk(slices):
    before = slices.locator(f"{AXIAL} canvas").bounding_box()["width"]
    slices.locator(f"{AXIAL} .enlarge").click()
    assert slices.locator(f"{AXIAL} canvas").bounding_box()["width"] > 1.5 * before
    slices.locator(f"{AXIAL} .enlarge").click()
    assert slices.locator(f"{AXIAL} canvas").bounding_box()["width"] == before


def test_pictures_say_what_they_show_to_those_who_do_not_see_them(slices):
    go_to(slices, 33, 27, 13)
    canvas = slices.locator(f"{AXIAL} canvas")
    assert canvas.get_attribute("role") == "img"
    said = canvas.get_attribute("aria-label")
    assert said.startswith("axial slice 14 of 20, about") and said.endswith("bone")


def test_windows_change_the_picture(slices, differ):
    pictures = []
    for name in ("soft tissue", "lung", "bone"):
        slices.locator(".windows button", has_text=name).click()
        slices.settle()
        pictures.append(read_pane(slices, "axial"))
        assert slices.locator(".windows [aria-pressed=true]").text_content() == name
    assert differ(pictures[0], pictures[1]) > 0.2 and differ(pictures[1], pictures[2]) > 0.2


def test_labels_can_be_hidden_and_faded(slices, differ):
    go_to(slices, 33, 27, 13)
    both = read_pane(slices, "axial")
    row = slices.locator(".slices .part", has_text="bone")
    row.locator("input[type=range]").evaluate(
        "e => { e.value = 1; e.dispatchEvent(new Event('input')); }"
    )
    slices.settle()
    strong = read_pane(slices, "axial")
    row.locator("input[type=checkbox]").uncheck()
    slices.settle()
    without = read_pane(slices, "axial")
    assert tuple(strong[27, 33]) == (0xF1, 0xE7, 0xC9)
    assert np.ptp(without[27, 33]) == 0  # grey again
    assert 0 < differ(both, without) < 0.2


def test_pixels_have_the_shape_of_the_voxels(slices):
    for plane, (wide, high) in {
        "axial": (96, 80),
        "coronal": (96, 80),
        "sagittal": (80, 80),
    }.items():
        box = slices.locator(f".pane[data-plane={plane}] canvas").bounding_box()
        assert box["width"] / box["height"] == pytest.approx(wide / high, rel=0.02)
