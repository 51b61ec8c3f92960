"""Tables as people read them: words for names, units in the heads, places in one cell."""

from dataclasses import dataclass
from math import isfinite
from numbers import Integral, Real
from typing import TYPE_CHECKING

import numpy as np

from nodes.mechanics.shapes import Figure
from nodes.reporting.colours import colour_names, words
from nodes.reporting.rendering import render_template

if TYPE_CHECKING:
    import pandas

UNITS = {
    "mm": "mm",
    "mm2": "mm²",
    "mm3": "mm³",
    "cm": "cm",
    "cm2": "cm²",
    "cm3": "cm³",
    "ml": "ml",
    "l": "l",
    "hu": "HU",
    "s": "s",
    "n": "N",
    "mpa": "MPa",
    "rad": "rad",
    "deg": "°",
    "percent": "%",
}
"""Units as column names end in them, and as people write them."""

HEADS = {"dice": "Dice"}
"""Heads that are not just the column's name in words."""

MISSING = "\u2013"

MOST_UNBROKEN = 24
"""Characters of the longest words in a column whose cells are not broken into lines."""

LEAST_GROUPED = 10_000
"""From here on, whole numbers are written in groups of three digits, a thin space between."""


@dataclass(frozen=True)
class Column:
    """One column ready for the page.

    Parameters
    ----------
    head, unit : what stands above it.
    kind : "number", "place" (x, y, z in one cell), "label" (with its colour), "short" (words that
        stay in one line) or "".
    cells : the texts.
    colours : "#rrggbb" for each cell of a label column, else "".
    """

    head: str
    unit: str
    kind: str
    cells: tuple[str, ...]
    colours: tuple[str, ...]


def render_table(table: "pandas.DataFrame", caption: str, decimals: int, unit_decimals: int) -> str:
    """Return the HTML of a table.

    Parameters
    ----------
    table : columns of numbers or words; `volume_ml` is headed "volume" in ml, `skin_x_mm`,
        `skin_y_mm` and `skin_z_mm` become one place (as do `x_mm`, `y_mm` and `z_mm`), and
        `label` gets the colours of the labels.
    caption : a sentence above it; may be empty.
    decimals, unit_decimals : digits after the point of numbers without and with a unit.
    """
    columns = prepare_columns(table, decimals, unit_decimals)
    values = {"columns": columns, "rows": len(table), "caption": caption}
    return render_template("table.html", values)


def prepare_columns(
    table: "pandas.DataFrame", decimals: int, unit_decimals: int
) -> tuple[Column, ...]:
    """Return the columns in their order; x, y and z of a place are one, where x stands."""
    values = {str(name): list(table[name]) for name in table}
    places = find_places(tuple(values))
    inside = {part for parts in places.values() for part in parts[1:]}
    columns = []
    for name, cells in values.items():
        if name in places:
            points = list(zip(*(values[part] for part in places[name]), strict=True))
            columns.append(
                place_column(name.removesuffix("x_mm").rstrip("_"), points, unit_decimals)
            )
        elif name not in inside:
            columns.append(plain_column(name, cells, decimals, unit_decimals))
    return tuple(columns)


def find_places(names: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """Return the columns x, y and z of each place, by the name of its x."""
    places = {}
    for name in names:
        stem = name.removesuffix("x_mm")
        parts = tuple(f"{stem}{axis}_mm" for axis in "xyz")
        if name == parts[0] and set(parts) <= set(names):
            places[name] = parts
    return places


def place_column(stem: str, points: list[tuple[float, ...]], decimals: int) -> Column:
    """Return places as a case's YAML takes them: [x, y, z], patient LPS mm."""
    cells = tuple(
        f"[{', '.join(show_value(value, decimals) for value in point)}]" for point in points
    )
    return Column(words(stem or "place"), "x, y, z in mm", "place", cells, ("",) * len(cells))


def plain_column(name: str, values: list[object], decimals: int, unit_decimals: int) -> Column:
    """Return a column of numbers, of words, or of labels with their colours."""
    head, unit = split_unit(name)
    if name == "label":
        named = tuple(str(value) for value in values)
        return Column(head, unit, "label", tuple(map(words, named)), colour_names(named))
    cells = tuple(show_value(value, unit_decimals if unit else decimals) for value in values)
    kind = "number" if all(is_number(value) or value is None for value in values) else ""
    if not kind and max(map(len, cells), default=0) <= MOST_UNBROKEN:
        kind = "short"
    return Column(head, unit, kind, cells, ("",) * len(cells))


def split_unit(column: str) -> tuple[str, str]:
    """Return a column's name as people read it, and its unit or ""."""
    name, _, end = column.rpartition("_")
    if name and end.lower() in UNITS:
        return words(HEADS.get(name, name)), UNITS[end.lower()]
    return words(HEADS.get(column, column)), ""


def show_value(value: object, decimals: int) -> str:
    """Return a cell's text; what is missing is a dash, yes and no are words.

    A number that is not 0 but would look like it has two significant digits instead.
    """
    if value is None:
        return MISSING
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, Integral):
        return group_digits(int(value))
    if isinstance(value, Real):
        if not isfinite(value):
            return MISSING
        small = 0 < abs(value) < 0.5 * 10**-decimals
        return f"{value:.2g}" if small else f"{value:.{decimals}f}"
    return str(value)


def group_digits(value: int) -> str:
    """Return a whole number, its digits in groups of three where it is long."""
    return f"{value:,}".replace(",", "\u202f") if abs(value) >= LEAST_GROUPED else f"{value}"


def is_number(value: object) -> bool:
    """Return whether a value is a number; yes and no are none."""
    return isinstance(value, Real) and not isinstance(value, bool | np.bool_)


def tell_shares(table: "pandas.DataFrame") -> "pandas.DataFrame":
    """Return a table whose shares, columns that begin so, are in %, its rates in whole numbers."""
    told = table.rename(
        columns={name: f"{name}_percent" for name in table if str(name).startswith("share")}
    )
    for name in told:
        if str(name).endswith("_percent"):
            told[name] = 100 * told[name]
        elif "_per_" in str(name):
            told[name] = told[name].round().astype("Int64").astype(object).fillna(np.nan)
    return told.rename(columns={"seconds": "time_s", "name": "set-up"})


def tabulate_figures(figures: tuple[Figure, ...]) -> "pandas.DataFrame":
    """Return one row a figure: what it is, its value with unit, what it means."""
    import pandas

    return pandas.DataFrame(to_rows(figures))


def to_rows(figures: tuple[Figure, ...]) -> list[dict[str, str]]:
    """Return each figure's name, value with unit, and meaning."""
    return [
        {
            "figure": figure.name,
            "value": tell_value(figure.value, figure.unit),
            "meaning": figure.meaning,
        }
        for figure in figures
    ]


def tell_value(value: float, unit: str) -> str:
    """Return a number with four significant digits and its unit."""
    return f"{value:.4g} {UNITS.get(unit, unit)}".rstrip()
