"""The published figures of a planner beside ours."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from nodes.reporting.artefacts import Section
from nodes.reporting.honesty import warnings_of
from nodes.reporting.parameters import ShowStudyParameters
from nodes.reporting.rendering import render_template
from nodes.reporting.share_curves import render_shares
from nodes.reporting.tables import render_table, tell_shares
from nodes.visibility.artefacts import VisibilitySets

if TYPE_CHECKING:
    import pandas

PARENT, START, UNION = "parent", "start", "union"
"""Seedings of solves by the neighbour's and by the start's solution, and all set-ups together, as
the table of a study calls them."""

HEADS = {
    PARENT: "Each solve begins at its neighbour's solution",
    START: "Each solve begins at the start's solution",
    "zero": "Each solve begins at zero",
}

RATIO = (
    "Nodes of the trees, and how many times more there are where each solve begins at its"
    " neighbour's solution, not at the start's. The ratio depends on the solver; nothing was tuned"
    " towards the paper's."
)


def show_study(
    study_table: "pandas.DataFrame",
    visibility_sets: VisibilitySets,
    parameters: ShowStudyParameters,
) -> Section:
    """Show the shares and nodes of [Kuntz2017] beside ours, all runs, and curves over time.

    Parameters
    ----------
    study_table : one row a tree and one for each union: `setup`, `seeding` ("parent", "start",
        "zero"), `share_seen` (0 to 1), `nodes`, `seconds`, and what else was counted.
    visibility_sets : of these trees.
    parameters : the paper's figures.
    """
    decimals = parameters.decimals
    html = render_template("paragraph.html", {"text": parameters.caption, "kind": "caption"})
    terms = tell_terms(study_table, parameters)
    html += render_table(compare_shares(study_table, parameters), terms, decimals, decimals)
    html += render_table(compare_nodes(study_table, parameters), RATIO, decimals, decimals)
    html += render_curves(study_table, visibility_sets, parameters.curve_points)
    html += render_table(tell_shares(study_table), "All runs.", decimals, decimals)
    return Section(parameters.title, html, warnings_of(visibility_sets.origin))


def render_curves(table: "pandas.DataFrame", sets: VisibilitySets, points: int) -> str:
    """Return the curves over time of the trees of each seeding, and of their union."""
    html = ""
    for seeding, rows in table.groupby("seeding", sort=False):
        names = set(rows["name"])
        own = replace(sets, sets=tuple(one for one in sets.sets if one.name in names))
        curves = render_shares(own, points)
        if curves:
            html += render_template("heading.html", {"text": HEADS.get(seeding, seeding)}) + curves
    return html


def tell_terms(table: "pandas.DataFrame", parameters: ShowStudyParameters) -> str:
    """Return on what terms the two sides were measured."""
    seconds = table["seconds"].max() if len(table) else float("nan")
    return (
        f"Share of the surface that is seen. Paper: {parameters.paper_hours:g} h on "
        f"{parameters.paper_cores} cores, another patient, other entry points; here: at most "
        f"{seconds:.0f} s. They may be set side by side, not subtracted."
    )


def setup_names(table: "pandas.DataFrame") -> list[str]:
    """Return the set-ups in the order of the table, without their union."""
    return [name for name in dict.fromkeys(table["setup"]) if name != UNION]


def pick(table: "pandas.DataFrame", setup: str, seeding: str, column: str) -> float:
    """Return one number of one run, or nan where there is no such run."""
    rows = table[(table["setup"] == setup) & (table["seeding"] == seeding)]
    return float(rows[column].iloc[0]) if len(rows) else np.nan


def pad(values: tuple[int, ...] | tuple[float, ...], count: int) -> list[float]:
    """Return the values, as many as wanted, nan where there is none."""
    return [*map(float, values), *[np.nan] * count][:count]


def compare_shares(
    table: "pandas.DataFrame", parameters: ShowStudyParameters
) -> "pandas.DataFrame":
    """Return one row a set-up, and one for the union."""
    import pandas

    names = setup_names(table)
    *single, union = parameters.paper_share_percent
    seeded = [*pad(tuple(single), len(names)), union]
    unseeded = [*pad(parameters.paper_unseeded_share_percent, len(names)), np.nan]
    rows = [
        {
            "set-up": name,
            "paper_percent": as_printed(paper),
            "here_percent": 100 * pick(table, name, PARENT, "share_seen"),
            "paper, seeded by the start_percent": as_printed(paper_start),
            "here, seeded by the start_percent": 100 * pick(table, name, START, "share_seen"),
        }
        for name, paper, paper_start in zip([*names, UNION], seeded, unseeded, strict=True)
    ]
    return pandas.DataFrame(rows, dtype=object)


def compare_nodes(table: "pandas.DataFrame", parameters: ShowStudyParameters) -> "pandas.DataFrame":
    """Return one row a set-up: nodes seeded and not, and their ratio."""
    import pandas

    names = setup_names(table)
    seeded = pad(parameters.paper_nodes, len(names))
    unseeded = pad(parameters.paper_unseeded_nodes, len(names))
    rows = []
    for name, paper, paper_start in zip(names, seeded, unseeded, strict=True):
        here, start = (pick(table, name, seeding, "nodes") for seeding in (PARENT, START))
        rows.append({
            "set-up": name,
            "paper": whole(paper), "paper, seeded by the start": whole(paper_start),
            "paper, ratio": paper / paper_start,
            "here": whole(here), "here, seeded by the start": whole(start),
            "here, ratio": here / start if start else np.nan,
            "here, nodes an hour": whole(pick(table, name, PARENT, "nodes_per_hour")),
        })  # fmt: skip
    return pandas.DataFrame(rows, dtype=object)


def as_printed(value: float) -> float | int:
    """Return a figure with the digits that the paper gives it: whole ones without a point."""
    return int(value) if float(value).is_integer() else value


def whole(value: float) -> int | None:
    """Return a number as a whole one; None where it is missing."""
    return int(value) if np.isfinite(value) else None
