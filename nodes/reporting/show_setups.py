"""Set-ups of CRISP robots in a patient, at their start, and the candidates they came from."""

from typing import TYPE_CHECKING

import numpy as np

from nodes.geometry.meshes import Surfaces
from nodes.planning.artefacts import CrispTree, CrispTrees, PlacedSetup
from nodes.reporting.artefacts import Section
from nodes.reporting.honesty import warnings_of
from nodes.reporting.parameters import ShowSetupsParameters
from nodes.reporting.robot_scene import (
    choose_thickness,
    draw_robot,
    name_needle,
    take_start,
    tell_thickness,
)
from nodes.reporting.scene import SCRIPTS, Choice, render_scene
from nodes.reporting.tables import render_table, tell_shares

if TYPE_CHECKING:
    import pandas


NEEDLES = "Needles of all set-ups; entries and tubes are those with which plans were computed."
ROUND = "share_round_"
"""How the columns begin that say what a candidate saw after each round of the search."""


def show_setups(
    crisp_trees: CrispTrees,
    setup_table: "pandas.DataFrame",
    surfaces: Surfaces,
    parameters: ShowSetupsParameters,
) -> Section:
    """Show each set-up where its robot starts, its needles, and the table of candidates.

    Parameters
    ----------
    crisp_trees : one a chosen set-up; its root is the start.
    setup_table : all candidates, the best first.
    surfaces : of the anatomy.
    parameters : what is shown, sizes, rows.

    Returns
    -------
    A section that needs the script of the 3-D viewer.
    """
    trees = tuple(
        tree for tree in crisp_trees.trees if not tree.placed.name.endswith(parameters.left_out)
    )
    html = render_starts(trees, surfaces, parameters) if trees else ""
    decimals = parameters.decimals
    needles = tabulate_needles(tuple(tree.placed for tree in trees))
    html += render_table(needles, NEEDLES if len(needles) else "", decimals, decimals)
    table = tell_candidates(setup_table.head(parameters.rows))
    html += render_table(table, tell_rows(len(setup_table), parameters.rows), decimals, decimals)
    scripts = SCRIPTS if trees else ()
    return Section(parameters.title, html, warnings_of(crisp_trees.origin), scripts)


def render_starts(
    trees: tuple[CrispTree, ...], surfaces: Surfaces, parameters: ShowSetupsParameters
) -> str:
    """Return the 3-D view of all set-ups at their starts, of which the reader chooses one."""
    chosen = tuple(pair for pair in surfaces.meshes if pair[0] in parameters.shown)
    setups = tuple(tree.placed.setup for tree in trees)
    points = [mesh.vertices_patient_mm for _, mesh in chosen]
    points += [setup.entry_points_patient_mm for setup in setups]
    thicker = choose_thickness(np.concatenate(points), setups, parameters.least_radius_share)
    marks = tuple(
        mark
        for choice, tree in enumerate(trees)
        for mark in draw_robot(take_start(tree), thicker, choice, parameters)
    )
    choices = tuple(Choice(tree.placed.name) for tree in trees)
    parts, below = Surfaces(chosen, surfaces.origin), tell_thickness(thicker)
    view = render_scene(parts, marks, parameters, below, choices)
    return f'<p class="choose" data-title="Set-up"></p>{view}'


def tabulate_needles(setups: tuple[PlacedSetup, ...]) -> "pandas.DataFrame":
    """Return one row a needle: where it enters, how far it reaches, how it is held."""
    import pandas

    return pandas.DataFrame([row for placed in setups for row in describe_needles(placed)])


def describe_needles(placed: PlacedSetup) -> list[dict[str, object]]:
    """Return the rows of one set-up."""
    setup, start = placed.setup, placed.start
    grasps = {snare.needle: snare for snare in setup.snares}
    rows = []
    for place, needle in enumerate(setup.needles):
        x, y, z = setup.entry_points_patient_mm[place]
        snare = grasps.get(place)
        held = (
            f"the camera tube: {snare.joint}, {snare.grasp_mm:g} mm from the {snare.measured_from}"
            if snare
            else f"the camera: {setup.field_of_view_deg:g}\N{DEGREE SIGN} field of view"
        )
        rows.append({
            "set-up": placed.name,
            "needle": name_needle(setup, place),
            "entry_x_mm": float(x), "entry_y_mm": float(y), "entry_z_mm": float(z),
            "length at start_mm": float(start.lengths_mm[place]),
            "diameters_mm": f"{needle.outer_diameter_mm:g} / {needle.inner_diameter_mm:g}",
            "holds": held,
        })  # fmt: skip
    return rows


def tell_candidates(table: "pandas.DataFrame") -> "pandas.DataFrame":
    """Return the table of candidates with what a reader compares; files have the rest.

    Of the shares after each round of the search the last stands for all: later rounds have more
    nodes and fewer candidates.
    """
    rounds = [name for name in table if str(name).startswith(ROUND)]
    told = table.drop(columns=["rank", "needles", *rounds], errors="ignore")
    if {"name", "chosen"} <= set(told):
        names = told["name"].where(told["chosen"], None)
        told = told.drop(columns=["name", "chosen"])
        told.insert(0, "chosen as", names)
    if rounds:
        place = told.columns.get_loc("share_unbent") + 1 if "share_unbent" in told else len(rounds)
        told.insert(place, "share_seen in its last round", table[rounds].ffill(axis=1).iloc[:, -1])
    told = told.rename(columns={"share_unbent": "share_seen by unbent starts"})
    return tell_shares(told)


def tell_rows(candidates: int, rows: int) -> str:
    """Return what the table of candidates leaves out."""
    if candidates <= rows:
        return "All candidates, the best first."
    return f"The best {rows} of {candidates} candidates; the table in the data folder has all."
