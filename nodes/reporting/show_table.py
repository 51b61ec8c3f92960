"""A table of numbers and words."""

from math import isfinite
from numbers import Integral, Real
from typing import TYPE_CHECKING

from nodes.reporting.artefacts import Section
from nodes.reporting.parameters import ShowTableParameters
from nodes.reporting.rendering import render_template

if TYPE_CHECKING:
    import pandas

UNITS = {
    "mm": "mm",
    "mm2": "mm²",
    "mm3": "mm³",
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


def show_table(table: "pandas.DataFrame", parameters: ShowTableParameters) -> Section:
    """Show a table: numbers to the right, units from the ends of the column names.

    Parameters
    ----------
    table : columns of numbers or words; a column `volume_ml` is headed "volume" in ml.
    parameters : title, caption and decimals.
    """
    columns = [[show_value(value, parameters.decimals) for value in table[name]] for name in table]
    heads = [
        {"name": name, "unit": unit, "number": all(number for _, number in column)}
        for (name, unit), column in zip(map(split_unit, table), columns, strict=True)
    ]
    rows = list(zip(*columns, strict=True))
    values = {"heads": heads, "rows": rows, "caption": parameters.caption}
    return Section(parameters.title, render_template("table.html", values))


def split_unit(column: object) -> tuple[str, str]:
    """Return a column's name as people read it, and its unit or ""."""
    name, _, end = str(column).rpartition("_")
    if name and end.lower() in UNITS:
        return name.replace("_", " "), UNITS[end.lower()]
    return str(column).replace("_", " "), ""


def show_value(value: object, decimals: int) -> tuple[str, bool]:
    """Return a cell's text and whether it is a number; what is missing is a dash."""
    if isinstance(value, Real) and not isinstance(value, bool):
        if isinstance(value, Integral):
            return f"{int(value)}", True
        return (f"{value:.{decimals}f}" if isfinite(value) else "\u2013"), True
    return ("\u2013" if value is None else str(value)), value is None
