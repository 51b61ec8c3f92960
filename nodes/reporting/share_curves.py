"""Curves of the share of a surface that is seen over time, as [Kuntz2017] Fig. 6 has them."""

import numpy as np
from jaxtyping import Float

from nodes.geometry.coverage import times_first_seen
from nodes.reporting.charts import Chart, Curve, render_chart
from nodes.reporting.rendering import render_template
from nodes.visibility.artefacts import VisibilitySets

COLOURS = 6
"""How many colours of curves page.css has."""

UNION_COLOUR = 5

KINDS = (
    ("Share of the whole surface that is seen", "dashed", True),
    ("Share of what each sees in the end", "solid", False),
)
"""Title, kind of line, and whether the share is of all cells."""


def render_shares(sets: VisibilitySets, points: int) -> str:
    """Return two charts: of all cells, and of those that each set-up sees at last.

    The paper draws both in one, dashed and solid; here they are dashed and solid, too, in a chart
    each, so that several set-ups stay readable. The union counts a cell from when any set-up has
    seen it, all growing side by side.

    Parameters
    ----------
    points : of each curve.
    """
    if not sets.sets or not len(sets.cells):
        return ""
    names = [one.name for one in sets.sets]
    firsts = [times_first_seen(one.first_nodes, one.seconds) for one in sets.sets]
    colours = [place % (COLOURS - 1) for place in range(len(names))]
    if len(names) > 1:
        names.append("union")
        firsts.append(np.fmin.reduce(firsts))
        colours.append(UNION_COLOUR)
    times = choose_times(firsts, points)
    charts = [
        Chart(
            title,
            "time of growing in s",
            "seen in %",
            tuple(
                Curve(
                    f"{tag_of(place)}  {name}",
                    times,
                    count_seen(first, times, is_of_all),
                    colour,
                    dash,
                    tag_of(place),
                )
                for place, (name, first, colour) in enumerate(
                    zip(names, firsts, colours, strict=True)
                )
            ),
            y_range=(0.0, 100.0),
            x_scale="log",
        )
        for title, dash, is_of_all in KINDS
    ]
    return render_template("charts.html", {"charts": [render_chart(chart) for chart in charts]})


def tag_of(place: int) -> str:
    """Return the letter that stands at a curve's end and in the key."""
    return chr(ord("a") + place % 26)


def choose_times(firsts: list[Float[np.ndarray, "cell"]], points: int) -> Float[np.ndarray, "n"]:
    """Return times from the first sight to the last, evenly on a logarithmic axis."""
    seen = np.concatenate([first[np.isfinite(first)] for first in firsts])
    seen = seen[seen > 0]
    if not len(seen):
        return np.zeros(0)
    return np.geomspace(seen.min(), seen.max(), points)


def count_seen(
    first: Float[np.ndarray, "cell"], times: Float[np.ndarray, "n"], is_of_all: bool
) -> Float[np.ndarray, "n"]:
    """Return the share in % of cells seen until each time, of all cells or of all ever seen."""
    seen = np.sort(first[np.isfinite(first)])
    cells = len(first) if is_of_all else max(len(seen), 1)
    return 100 * np.searchsorted(seen, times * (1 + 1e-12), side="right") / cells
