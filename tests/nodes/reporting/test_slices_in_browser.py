"""The slice viewer in a real browser: exact labels, true places, and working controls."""

import numpy as np
import pytest

from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from nodes.reporting.show_slices import show_slices

AXIAL = ".pane[data-plane=axial]"


@pytest.fixture
def slices(show, box_with_ball, defaults):
    """A page with the box and its ball in slices, all labels on."""
    return show(show_slices(*box_with_ball, defaults("show_slices", hidden_labels=[])))


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
    decoded = slices.evaluate("Array.from(document.querySelector('.slices').viewer.labelVoxels)")
    labels = np.array(decoded, np.uint8).reshape(box_with_ball[1].voxels.shape, order="F")
    assert np.array_equal(labels, box_with_ball[1].voxels)


def test_255_labels_are_decoded_exactly(show, box_with_ball, defaults):
    volume, _ = box_with_ball
    voxels = (np.arange(volume.voxels.size) % 256).astype(np.uint8).reshape(volume.voxels.shape)
    names = tuple(f"part_{n}" for n in range(255))
    label_map = LabelMap(voxels, volume.patient_from_index, names, Origin("stripes"))
    page = show(show_slices(volume, label_map, defaults("show_slices")))
    decoded = page.evaluate("Array.from(document.querySelector('.slices').viewer.labelVoxels)")
    assert np.array_equal(np.array(decoded).reshape(voxels.shape, order="F"), voxels)


def test_values_are_decoded_nearly(slices, box_with_ball):
    decoded = slices.evaluate(
        "(() => { const v = document.querySelector('.slices').viewer;"
        " return Array.from(v.greyVoxels, g => v.values[g]); })()"
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
    box = slices.locator(f"{AXIAL} .frame").bounding_box()
    slices.locator(f"{AXIAL} .frame").scroll_into_view_if_needed()
    box = slices.locator(f"{AXIAL} .frame").bounding_box()
    slices.mouse.click(box["x"] + box["width"] * 33.5 / 48, box["y"] + box["height"] * 27.5 / 40)
    slices.settle()
    assert slices.evaluate("document.querySelector('.slices').viewer.at") == [33, 27, 5]
    assert slices.locator(".pane[data-plane=sagittal]").get_attribute("data-slice") == "33"


def test_the_readout_names_place_value_and_label(slices):
    go_to(slices, 33, 27, 13)
    text = slices.locator(".readout").first.text_content()
    assert text.startswith("L 18  P 14  S 152 mm") and text.endswith("bone") and "HU" in text


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
    assert tuple(strong[27, 33]) == (0xE6, 0xD8, 0xB0)
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
