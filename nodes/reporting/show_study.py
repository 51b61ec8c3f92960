"""The published figures of a planner beside ours."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from nodes.geometry.grids import spacing_mm
from nodes.planning.artefacts import CrispTrees
from nodes.reporting.artefacts import Section
from nodes.reporting.honesty import warnings_of
from nodes.reporting.parameters import ShowStudyParameters
from nodes.reporting.rendering import render_template
from nodes.reporting.share_curves import render_shares
from nodes.reporting.tables import group_digits, render_table, tell_shares
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

SHARE = "Share of the surface that is seen; the union is of both set-ups."
RATIO = (
    "Nodes of the trees, and how many times more there are where each solve begins at its"
    " neighbour's solution, not at the start's. The ratio depends on the solver; nothing was tuned"
    " towards the paper's."
)
TERMS = "On what terms: what differs between the two."
RUNS = (
    "All runs here. A solve is one configuration; failures are edges that ended since a step was"
    " not solved. A union is of one seeding's set-ups, its numbers their sums."
)
SEEDS = {PARENT: "its neighbour", START: "the start", "zero": "zero"}
"""Where solves begin, as the table of all runs says it."""


def show_study(
    study_table: "pandas.DataFrame",
    visibility_sets: VisibilitySets,
    crisp_trees: CrispTrees,
    parameters: ShowStudyParameters,
) -> Section:
    """Show the shares and nodes of [Kuntz2017] beside ours, all runs, and curves over time.

    Parameters
    ----------
    study_table : one row a tree and one for each union: `setup`, `seeding` ("parent", "start",
        "zero"), `share_seen` (0 to 1), `nodes`, `seconds`, and what else was counted.
    visibility_sets : of these trees.
    crisp_trees : of which it is told how many grew side by side, and with which camera.
    parameters : the paper's figures.
    """
    decimals = parameters.decimals
    html = render_template("paragraph.html", {"text": parameters.caption, "kind": "caption"})
    html += render_table(compare_shares(study_table, parameters), SHARE, decimals, decimals)
    html += render_table(compare_nodes(study_table, parameters), RATIO, decimals, decimals)
    html += render_curves(study_table, visibility_sets, parameters.curve_points)
    terms = compare_terms(study_table, visibility_sets, crisp_trees, parameters)
    html += render_table(terms, TERMS, decimals, decimals)
    html += render_table(tell_runs(study_table), RUNS, decimals, decimals)
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


def compare_terms(
    table: "pandas.DataFrame",
    sets: VisibilitySets,
    trees: CrispTrees,
    parameters: ShowStudyParameters,
) -> "pandas.DataFrame":
    """Return on what terms the two sides were measured, one row each."""
    import pandas

    side_by_side = max((int(tree.trees.max(initial=0)) + 1 for tree in trees.trees), default=0)
    angles = sorted({tree.placed.setup.field_of_view_deg for tree in trees.trees})
    cell = float(spacing_mm(sets.patient_from_index).max())
    rows = [
        ("time for each tree", f"{parameters.paper_hours:g} h", tell_time(table)),
        ("cores", f"{parameters.paper_cores}", f"{side_by_side} trees at once, each on a core"),
        (
            "cells of the surface",
            f"about {group_digits(parameters.paper_cells)}",
            f"{group_digits(len(sets.cells))} of {cell:g} mm",
        ),
        ("surface", "effusion in a patient's CT", "of this case, as the head of the page tells"),
        ("entry points", "not told how they were chosen", "found by a search, between ribs"),
        (
            "field of view",
            "not told",
            ", ".join(f"{angle:g}\N{DEGREE SIGN}" for angle in angles),
        ),
        ("looking for cells", "not told whether within that time", "not within that time"),
    ]
    return pandas.DataFrame(rows, columns=["", "paper", "here"])


def tell_time(table: "pandas.DataFrame") -> str:
    """Return for how long trees grew here at most."""
    return f"{table['seconds'].max():.0f} s" if len(table) else "no tree"


def tell_runs(table: "pandas.DataFrame") -> "pandas.DataFrame":
    """Return the table of all runs as people read it: names in words, set-up and seed once."""
    told = tell_shares(table.drop(columns="name", errors="ignore"))
    told["seeding"] = told["seeding"].map(lambda seed: SEEDS.get(seed, seed))
    return told.rename(columns={"setup": "set-up", "seeding": "solves begin at"})


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
