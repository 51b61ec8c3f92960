import pytest
from jinja2 import UndefinedError

from nodes.reporting.rendering import format_moment, format_seconds, render_template


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "0 ms"),
        (0.012, "12 ms"),
        (0.0999, "0.1 s"),
        (9.96, "10 s"),
        (99.0, "99 s"),
        (100.0, "2 min"),
        (3600.0, "60 min"),
        (7200.0, "2.0 h"),
    ],
)
def test_seconds_read_as_people_say_them(seconds, text):
    assert format_seconds(seconds) == text


def test_a_missing_value_is_an_error():
    with pytest.raises(UndefinedError):
        render_template("table.html", {"columns": []})


def test_text_is_escaped(hostile):
    column = {"head": hostile, "unit": "", "kind": "", "cells": [hostile], "colours": [""]}
    html = render_template("table.html", {"columns": [column], "rows": 1, "caption": hostile})
    assert "<script" not in html and "&lt;script&gt;" in html


@pytest.mark.parametrize(
    ("moment", "text"),
    [
        ("2025-01-03T14:02:11Z", "2025-01-03 14:02:11 UTC"),
        ("2025-01-03T14:02:11.25Z", "2025-01-03 14:02:11 UTC"),
        ("yesterday", "yesterday"),
        ("", ""),
    ],
)
def test_moments_read_as_people_write_them(moment, text):
    assert format_moment(moment) == text
