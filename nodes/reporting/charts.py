"""Charts as SVG: curves over a linear or logarithmic axis, readable on a phone and without colour.

Colours are classes of page.css, so that they change with the page from light to dark.
"""

from dataclasses import dataclass
from math import ceil, floor, log10
from typing import Literal

import numpy as np
from jaxtyping import Float

from nodes.reporting.rendering import render_template

WIDTH, HEIGHT = 380, 264
LEFT, RIGHT, TOP, BOTTOM = 48.0, 350.0, 12.0, 222.0
"""Of the picture and of the field in it, in units of the picture; page.css sets its letters."""

MOST_TICKS = 6
TAG_HEIGHT = 13
"""How far apart names at the ends of curves stand at least, in units of the picture."""


@dataclass(frozen=True)
class Curve:
    """A line through points.

    Parameters
    ----------
    name : in the key; empty for none.
    xs, ys : (n,) in the axes' units; what is not finite is left out.
    colour : 0 to 5, the place among the page's colours of curves.
    dash : kind of line.
    tag : short name that stands at the curve's end.
    """

    name: str
    xs: Float[np.ndarray, "n"]
    ys: Float[np.ndarray, "n"]
    colour: int = 0
    dash: Literal["solid", "dashed", "dotted"] = "solid"
    tag: str = ""


@dataclass(frozen=True)
class Chart:
    """Curves in one field.

    Parameters
    ----------
    x_label, y_label : what the axes show, with unit.
    limits : values on the y axis that are marked by a line, each with its name.
    y_range : least range of the y axis; curves beyond it widen it.
    x_scale : of the x axis; logarithmic ones leave out what is not positive.
    follows : whether a line moves along x with the motion of the section's 3-D view.
    """

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    limits: tuple[tuple[float, str], ...] = ()
    y_range: tuple[float, float] | None = None
    x_scale: Literal["linear", "log"] = "linear"
    follows: bool = False


@dataclass(frozen=True)
class Axis:
    """Values from `low` to `high` at places from `start` to `end` of the picture."""

    low: float
    high: float
    start: float
    end: float

    def place(self, values: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n"]:
        """Return where values stand."""
        return self.start + (values - self.low) / (self.high - self.low) * (self.end - self.start)


def render_chart(chart: Chart) -> str:
    """Return the HTML of a chart; a sentence where no curve has a point."""
    is_log = chart.x_scale == "log"
    drawn = [(curve, *finite_points(curve, is_log)) for curve in chart.curves]
    drawn = [(curve, xs, ys) for curve, xs, ys in drawn if len(xs)]
    if not drawn:
        return render_template("no_chart.html", {"title": chart.title})
    limits = np.array([value for value, _ in chart.limits])
    x = Axis(*span([xs for _, xs, _ in drawn]), LEFT, RIGHT)
    y = make_y_axis([*(ys for _, _, ys in drawn), limits, np.array(chart.y_range or ())])
    x_ticks = (choose_powers if is_log else choose_ticks)(x.low, x.high)
    y_ticks = choose_ticks(y.low, y.high)
    x_names = [tell_power(tick) if is_log else f"{tick:g}" for tick in x_ticks]
    ends = [(one, x.place(xs)[-1], y.place(ys)[-1]) for one, xs, ys in drawn if one.tag]
    values = {
        "chart": chart,
        "x_ticks": place_ticks(x.place(x_ticks), x_names),
        "y_ticks": place_ticks(y.place(y_ticks), [f"{tick:g}" for tick in y_ticks]),
        "limits": place_ticks(y.place(limits), [name for _, name in chart.limits]),
        "lines": [(one, draw_path(x.place(xs), y.place(ys))) for one, xs, ys in drawn],
        "tags": place_tags(ends),
        "keys": [curve for curve, _, _ in drawn if curve.name],
        "width": WIDTH, "height": HEIGHT,
        "left": LEFT, "right": RIGHT, "top": TOP, "bottom": BOTTOM,
    }  # fmt: skip
    return render_template("chart.html", values)


def make_y_axis(groups: list[Float[np.ndarray, "_"]]) -> Axis:
    """Return an axis that has all values, widened to the ticks just beyond them."""
    low, high = span(groups)
    ticks = choose_ticks(low, high)
    step = ticks[1] - ticks[0] if len(ticks) > 1 else 0.0
    low = ticks[0] - step if low < ticks[0] - 1e-9 * step else low
    high = ticks[-1] + step if high > ticks[-1] + 1e-9 * step else high
    return Axis(float(low), float(high), BOTTOM, TOP)


def finite_points(
    curve: Curve, is_log: bool
) -> tuple[Float[np.ndarray, "n"], Float[np.ndarray, "n"]]:
    """Return the points of a curve that can be drawn, x as its logarithm where the axis is one."""
    xs, ys = np.asarray(curve.xs, float), np.asarray(curve.ys, float)
    kept = np.isfinite(xs) & np.isfinite(ys) & ((xs > 0) | (not is_log))
    return (np.log10(xs[kept]) if is_log else xs[kept]), ys[kept]


def span(groups: list[Float[np.ndarray, "_"]]) -> tuple[float, float]:
    """Return the least and largest value of all groups, one apart at least if they are alike."""
    values = np.concatenate(groups)
    low, high = float(values.min()), float(values.max())
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def choose_ticks(low: float, high: float) -> Float[np.ndarray, "n"]:
    """Return at most six round numbers within a range, 1, 2 or 5 times a power of ten apart."""
    rough = (high - low) / (MOST_TICKS - 1)
    power = 10.0 ** floor(log10(rough))
    step = next(times * power for times in (1, 2, 5, 10) if times * power >= rough * (1 - 1e-9))
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    return np.arange(first, last + 1) * step


def choose_powers(low: float, high: float) -> Float[np.ndarray, "n"]:
    """Return the whole powers of ten between two logarithms, with 2 and 5 times where few are."""
    times = (0.0,) if high - low > 3 else (0.0, log10(2), log10(5))
    powers = range(floor(low), ceil(high) + 1)
    ticks = np.array([power + more for power in powers for more in times])
    return ticks[(ticks >= low - 1e-9) & (ticks <= high + 1e-9)]


def tell_power(logarithm: float) -> str:
    """Return the number with that logarithm, as people write it."""
    return f"{10.0**logarithm:.6g}"


def place_ticks(places: Float[np.ndarray, "n"], texts: list[str]) -> list[dict[str, object]]:
    """Return ticks as the template takes them."""
    pairs = zip(places, texts, strict=True)
    return [{"at": round(float(at), 1), "text": text} for at, text in pairs]


def draw_path(xs: Float[np.ndarray, "n"], ys: Float[np.ndarray, "n"]) -> str:
    """Return an SVG path through points in units of the picture."""
    pairs = [f"{x:.1f} {y:.1f}" for x, y in zip(xs, ys, strict=True)]
    return "M" + "L".join(dict.fromkeys(pairs)) + ("h0.1" if len(pairs) == 1 else "")


def place_tags(ends: list[tuple[Curve, float, float]]) -> list[dict[str, object]]:
    """Return names at the ends of curves, pushed apart until none covers another."""
    tags, row = [], -float("inf")
    for curve, x, y in sorted(ends, key=lambda end: end[2]):
        row = max(y, row + TAG_HEIGHT)
        tags.append({"x": round(x + 4, 1), "y": round(row, 1), "curve": curve})
    return tags
