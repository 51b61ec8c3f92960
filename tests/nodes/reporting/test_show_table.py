from html.parser import HTMLParser

import pandas
import pytest

from nodes.reporting.colours import colour_names
from nodes.reporting.show_table import show_table
from nodes.reporting.tables import show_value


class Cells(HTMLParser):
    """Collects (tag, class, text) of the cells of a table."""

    def __init__(self, html):
        super().__init__()
        self.cells, self.inside = [], False
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        if tag in ("td", "th"):
            self.cells.append([tag, dict(attrs).get("class", ""), ""])
            self.inside = True

    def handle_endtag(self, tag):
        self.inside = self.inside and tag not in ("td", "th")

    def handle_data(self, data):
        if self.inside:
            self.cells[-1][2] += data


@pytest.fixture
def cells(defaults):
    def cells(table, **changes):
        return Cells(show_table(table, defaults("show_measures", **changes)).html).cells

    return cells


def test_numbers_stand_right_and_words_left(cells):
    found = cells(pandas.DataFrame({"name": ["lung"], "parts": [2], "volume_ml": [4321.126]}))
    assert [(kind, text) for tag, kind, text in found if tag == "td"] == [
        ("short", "lung"),
        ("number", "2"),
        ("number", "4321.1"),
    ]


def test_decimals_are_a_parameter(cells):
    table = pandas.DataFrame({"dice": [0.98765], "volume_ml": [12.3456]})
    found = cells(table, decimals=4, unit_decimals=2)
    assert [text for *_, text in found[-2:]] == ["0.9877", "12.35"]


@pytest.mark.parametrize(
    ("column", "head"),
    [
        ("volume_ml", "volume ml"),
        ("area_mm2", "area mm²"),
        ("wall_hu", "wall HU"),
        ("number_of_parts", "number of parts"),
        ("s", "s"),
        ("volume_error_percent", "volume error %"),
        ("surface_area_cm2", "surface area cm²"),
        ("dice", "Dice"),
        (3, "3"),
    ],
)
def test_units_come_from_the_column_names(cells, column, head):
    assert cells(pandas.DataFrame({column: [1.0]}))[0][2] == head


def test_what_is_missing_is_a_dash(cells):
    found = cells(pandas.DataFrame({"dice": [float("nan"), 0.5], "word": ["a", None]}))
    assert [text for tag, _, text in found if tag == "td"] == ["\u2013", "a", "0.500", "\u2013"]
    assert found[0][1] == "number"


def test_a_place_is_one_cell_as_a_case_takes_it(cells):
    columns = {"depth_mm": [1.0], "skin_x_mm": [-1.26], "skin_y_mm": [2.0], "skin_z_mm": [30.04]}
    found = cells(pandas.DataFrame(columns | {"tip_x_mm": [7.0]}))
    assert [text for *_, text in found[:3]] == ["depth mm", "skin x, y, z in mm", "tip x mm"]
    assert found[4] == ["td", "place", "[-1.3, 2.0, 30.0]"]


def test_a_place_needs_no_name_of_its_own(cells):
    found = cells(pandas.DataFrame({"site": ["a"], "x_mm": [1.0], "y_mm": [2.0], "z_mm": [3.0]}))
    assert [text for *_, text in found] == ["site", "place x, y, z in mm", "a", "[1.0, 2.0, 3.0]"]


def test_labels_stand_in_words_with_their_colour(defaults):
    html = show_table(pandas.DataFrame({"label": ["left_lung"]}), defaults("show_measures")).html
    assert "left lung" in html and "left_lung" not in html
    assert f"background:{colour_names(('left_lung',))[0]}" in html


def test_yes_and_no_are_words(cells):
    found = cells(pandas.DataFrame({"reached": [True, False]}))
    assert [text for tag, _, text in found if tag == "td"] == ["yes", "no"]


def test_a_table_without_rows_says_so(cells):
    assert cells(pandas.DataFrame({"dice": []}))[-1][2] == "no rows"


def test_words_stay_text(cells, hostile):
    found = cells(pandas.DataFrame({hostile: [hostile]}))
    assert [text for *_, text in found] == [hostile.replace("_", " "), hostile]


def test_a_small_number_does_not_look_like_none():
    assert [show_value(v, 1) for v in (0.0117, 0.0, 0.05, -0.04, 12.34)] == [
        "0.012", "0.0", "0.1", "-0.04", "12.3",
    ]  # fmt: skip
