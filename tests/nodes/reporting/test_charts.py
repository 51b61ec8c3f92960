import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodes.reporting import charts
from nodes.reporting.charts import Chart, Curve, choose_powers, choose_ticks, render_chart


def make_chart(xs, ys, **named):
    return Chart("title", "time in s", "share in %", (Curve("one", xs, ys),), **named)


def points_of(html):
    path = re.search(r'<path class="curve[^"]*" d="([^"]*)"/>\n', html).group(1)
    return np.array([pair.split() for pair in path.strip("M").split("L")], float)


def labels_of(html, axis):
    found = re.findall(rf'class="tick {axis}" x="([^"]*)" y="([^"]*)">([^<]*)<', html)
    return [(float(x), float(y), float(text)) for x, y, text in found]


def test_a_curve_stands_where_the_ticks_of_both_axes_say():
    xs, ys = np.array([0.0, 10, 20]), np.array([0.0, 50, 100])
    html = render_chart(make_chart(xs, ys))
    drawn = points_of(html)
    ticks_x, ticks_y = labels_of(html, "x"), labels_of(html, "y")
    to_x = np.polyfit([x for x, _, _ in ticks_x], [value for _, _, value in ticks_x], 1)
    to_y = np.polyfit([y for _, y, _ in ticks_y], [value for _, _, value in ticks_y], 1)
    assert np.polyval(to_x, drawn[:, 0]) == pytest.approx(xs, abs=0.02)
    assert np.polyval(to_y, drawn[:, 1]) == pytest.approx(ys, abs=0.1)


def test_equal_factors_are_equal_ways_on_a_logarithmic_axis():
    html = render_chart(make_chart(np.array([0.01, 0.1, 1, 10]), np.arange(4.0), x_scale="log"))
    assert np.diff(points_of(html)[:, 0]) == pytest.approx(np.full(3, 302 / 3), abs=0.1)
    assert [text for *_, text in labels_of(html, "x")] == [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5,
                                                           10]  # fmt: skip


def test_what_is_not_finite_or_has_no_logarithm_is_left_out():
    xs, ys = np.array([0.0, 1, 2, 3]), np.array([1.0, 2, np.nan, 4])
    assert len(points_of(render_chart(make_chart(xs, ys)))) == 3
    assert len(points_of(render_chart(make_chart(xs, ys, x_scale="log")))) == 2


def test_a_chart_without_points_says_so():
    html = render_chart(make_chart(np.zeros(0), np.zeros(0)))
    assert "Nothing to draw" in html and "<svg" not in html


def test_curves_are_told_apart_without_colour():
    xs = np.arange(3.0)
    curves = (Curve("one", xs, xs, 0, "solid", "a"), Curve("two", xs, 2 * xs, 1, "dashed", "b"))
    html = render_chart(Chart("title", "x", "y", curves))
    assert 'class="curve c0 solid"' in html and 'class="curve c1 dashed"' in html
    assert re.findall(r'class="tag c\d" [^>]*>(\w)<', html) == ["b", "a"]  # from top to bottom


def test_names_at_the_ends_of_curves_never_cover_one_another():
    xs = np.arange(3.0)
    curves = tuple(Curve(f"{n}", xs, xs + n / 100, n, tag=f"{n}") for n in range(5))
    html = render_chart(Chart("title", "x", "y", curves))
    rows = sorted(float(y) for y in re.findall(r'class="tag c\d" x="[^"]*" y="([^"]*)"', html))
    assert min(np.diff(rows)) > charts.TAG_HEIGHT - 0.11  # places are rounded


def test_a_limit_is_within_the_chart_and_has_its_name():
    html = render_chart(make_chart(np.arange(3.0), np.arange(5.0, 8), limits=((0.0, "touches"),)))
    place = float(re.search(r'class="limit" d="M[\d.]+ ([\d.]+)H', html).group(1))
    assert charts.TOP <= place <= charts.BOTTOM and "touches" in html


def test_texts_of_a_chart_are_escaped(hostile):
    xs = np.arange(3.0)
    html = render_chart(Chart(hostile, hostile, hostile, (Curve(hostile, xs, xs, tag=hostile),)))
    assert "<script" not in html and "<b " not in html


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6))
def test_ticks_are_few_round_and_within_the_range(low, size):
    ticks = choose_ticks(low, low + size)
    assert 1 <= len(ticks) <= charts.MOST_TICKS
    slack = 1e-6 * size
    assert ticks[0] >= low - slack and ticks[-1] <= low + size + slack
    if len(ticks) > 1:
        first = f"{ticks[1] - ticks[0]:.3e}"[0]
        assert first in "125"


@given(st.floats(-6, 6), st.floats(0.5, 8))
def test_powers_of_ten_are_within_the_range(low, size):
    ticks = choose_powers(low, low + size)
    assert all(low - 1e-9 <= tick <= low + size + 1e-9 for tick in ticks)
    assert len(ticks) >= 1
