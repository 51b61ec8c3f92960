"""A table of numbers and words."""

from typing import TYPE_CHECKING

from nodes.reporting.artefacts import Section
from nodes.reporting.parameters import ShowTableParameters
from nodes.reporting.tables import render_table

if TYPE_CHECKING:
    import pandas


def show_table(table: "pandas.DataFrame", parameters: ShowTableParameters) -> Section:
    """Show a table: numbers to the right, units from the ends of the column names.

    Parameters
    ----------
    table : columns of numbers or words; a column `volume_ml` is headed "volume" in ml, and the
        names in a column `label` have their colours beside them.
    parameters : title, caption and decimals.
    """
    html = render_table(table, parameters.caption, parameters.decimals, parameters.unit_decimals)
    return Section(parameters.title, html)
