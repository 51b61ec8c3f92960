import re
from xml.etree import ElementTree

import pytest

from nodes.reporting.artefacts import StageAccount
from nodes.reporting.pipeline_picture import draw_pipeline

SVG = "{http://www.w3.org/2000/svg}"


def draw(stages, inputs=("ct_files",), columns=3, box_width=170.0):
    svg = draw_pipeline(stages, inputs, columns, box_width, "test")
    return ElementTree.fromstring(svg.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" '))


def boxes_of(tree):
    """Return (left, top, right, bottom, texts) of every box."""
    boxes = []
    for group in tree.findall(f"{SVG}g"):
        x, y = map(float, re.findall(r"[-\d.]+", group.get("transform")))
        rect = group.find(f"{SVG}rect")
        left, top = x + float(rect.get("x")), y + float(rect.get("y"))
        right, bottom = left + float(rect.get("width")), top + float(rect.get("height"))
        texts = [text.text for text in group.findall(f"{SVG}text")]
        boxes.append((left, top, right, bottom, texts))
    return boxes


@pytest.mark.parametrize("columns", [1, 2, 5])
def test_boxes_stay_in_the_picture_and_apart(run_account, columns):
    tree = draw(run_account.stages, columns=columns)
    _, _, width, height = map(float, tree.get("viewBox").split())
    boxes = boxes_of(tree)
    for n, (left, top, right, bottom, _) in enumerate(boxes):
        assert 0 <= left < right <= width and 0 <= top < bottom <= height
        for other in boxes[:n]:
            beside = right <= other[0] or other[2] <= left
            assert beside or bottom <= other[1] or other[3] <= top


def test_every_stage_says_what_happened_and_how_long_it_took(run_account):
    words = {texts[0]: texts[1] for *_, texts in boxes_of(draw(run_account.stages))}
    assert words["read_volume"] == "computed · 1.2 s"
    assert words["segment_ct"] == "from cache · 12 s"
    assert words["build_case_page"] == "this page"
    assert words["ct_files"] == "input"
    assert "run_account" not in words


def test_every_reading_is_an_arrow_that_ends_at_its_reader(run_account):
    tree = draw(run_account.stages, columns=1)
    tops = {texts[0]: (left, right, top) for left, top, right, _, texts in boxes_of(tree)}
    ends = [
        (path.find(f"{SVG}title").text, *map(float, re.findall(r"[-\d.]+", path.get("d"))[-2:]))
        for path in tree.findall(f"{SVG}path")
    ]
    readings = [
        (name, stage.name)
        for stage in run_account.stages
        for name in stage.inputs
        if name != "run_account"
    ]
    assert len(ends) == len(readings)
    for dataset, reader in readings:
        left, right, top = tops[reader]
        assert any(
            name == dataset and left < x < right and top - 5 <= y <= top for name, x, y in ends
        )


def test_names_are_text_whatever_they_hold(hostile):
    stage = StageAccount(
        hostile, hostile, (hostile,), (hostile + "2",), "computed", (), 1.0, "", ()
    )
    tree = draw((stage,), inputs=(hostile,))
    assert {texts[0] for *_, texts in boxes_of(tree)} == {hostile}
    assert not list(tree.iter(f"{SVG}script")) and not list(tree.iter("script"))
