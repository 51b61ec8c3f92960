"""What set-ups see of a cavity's surface: in 3-D, over time, and in a table."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, UInt8

from nodes.geometry.coverage import times_first_seen
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import Volume
from nodes.geometry.meshes import Surfaces
from nodes.planning.artefacts import CrispTree, CrispTrees
from nodes.reporting.artefacts import Section
from nodes.reporting.cavity_surface import draw_cavity
from nodes.reporting.honesty import warnings_of
from nodes.reporting.parameters import ShowVisibilityParameters
from nodes.reporting.rendering import format_seconds
from nodes.reporting.robot_scene import choose_thickness, draw_robot, take_start, tell_thickness
from nodes.reporting.scene import SCRIPTS, Choice, Mark, Paint, Shown, render_scene
from nodes.reporting.share_curves import render_shares
from nodes.reporting.tables import render_table, tell_shares
from nodes.visibility.artefacts import VisibilitySet, VisibilitySets

if TYPE_CHECKING:
    import pandas

Kinds = UInt8[np.ndarray, "v"]

UNSEEN, SEEN, BOTH = "#a9b0b5", "#e07b00", "#7b3fa0"
ONLY = ("#e07b00", "#0a76b8")
"""What one of two set-ups sees alone; the paper's Fig. 5 is orange, too."""
EARLY, LATE = (255, 226, 120), (96, 20, 80)
"""First seen at the beginning, bright, and at the end, dark: the order is read without colour."""


def show_visibility(
    visibility_sets: VisibilitySets,
    crisp_trees: CrispTrees,
    distance_field: Volume,
    visibility_table: "pandas.DataFrame",
    parameters: ShowVisibilityParameters,
) -> Section:
    """Show the cavity's surface in colours of who sees it and since when, and curves over time.

    Parameters
    ----------
    visibility_sets : what each set-up sees of the boundary cells.
    crisp_trees : whose starts are drawn.
    distance_field : signed distance to the walls, from which the surface is drawn, mm.
    visibility_table : one row a set-up and one for their union.
    parameters : what is shown, sizes, spans of time.

    Returns
    -------
    A section that needs the script of the 3-D viewer.
    """
    ends = parameters.left_out
    sets = replace(
        visibility_sets,
        sets=tuple(one for one in visibility_sets.sets if not one.name.endswith(ends)),
    )
    trees = tuple(tree for tree in crisp_trees.trees if not tree.placed.name.endswith(ends))
    html = '<p class="choose" data-title="Robot shown"></p>'
    html += render_seen(sets, trees, distance_field, parameters)
    html += render_shares(sets, parameters.curve_points)
    if len(sets.sets) < len(visibility_sets.sets):
        shown = [one.name for one in sets.sets]
        visibility_table = visibility_table[visibility_table["name"].isin(shown)]
    table = tell_shares(visibility_table)
    html += render_table(table, "", parameters.decimals, parameters.decimals)
    origins = (visibility_sets.origin, crisp_trees.origin)
    return Section(parameters.title, html, warnings_of(*origins), SCRIPTS)


def render_seen(
    sets: VisibilitySets,
    trees: tuple[CrispTree, ...],
    distance_field: Volume,
    parameters: ShowVisibilityParameters,
) -> str:
    """Return the 3-D view of the painted surface and of the robots, of which one is shown."""
    cavity = draw_cavity(distance_field, parameters.cell_mm, parameters.smoothing_mm)
    vertices = cavity.vertices_patient_mm
    paints = make_paints(sets, vertices, parameters.times, parameters.neighbours)
    opacity = parameters.cavity_opacity
    marks: tuple[Shown, ...] = (Mark("cavity", cavity, SEEN, opacity=opacity, paints=paints),)
    below = ""
    if trees and len(vertices):
        setups = tuple(tree.placed.setup for tree in trees)
        thicker = choose_thickness(vertices, setups, parameters.least_radius_share)
        below = tell_thickness(thicker)
        for choice, tree in enumerate(trees):
            marks += draw_robot(take_start(tree), thicker, choice, parameters)
    choices = tuple(Choice(tree.placed.name) for tree in trees)
    return render_scene(Surfaces((), sets.origin), marks, parameters, below, choices)


def make_paints(
    sets: VisibilitySets, vertices_mm: Float[np.ndarray, "v 3"], times: int, neighbours: int
) -> tuple[Paint, ...]:
    """Return what the surface's colours may tell.

    A vertex has the kind of most of the cells next to it, the first of equal ones: single cells in
    the corners of stairs, which the drawn surface has not, would speckle it.

    Parameters
    ----------
    times : spans of time.
    neighbours : how many cells next to a vertex are asked.
    """
    from scipy.spatial import cKDTree

    if not (len(sets.cells) and len(vertices_mm) and sets.sets):
        return ()
    centres = transform_points(sets.patient_from_index, sets.cells.astype(float))
    count = min(neighbours, len(centres))
    _, nearest = cKDTree(centres).query(vertices_mm, np.arange(1, count + 1))
    seen = np.stack([one.first_nodes >= 0 for one in sets.sets])
    paints = [paint_together(sets.sets, seen)] if len(seen) > 1 else []
    paints += [paint_seen(one) for one in sets.sets]
    firsts = [times_first_seen(one.first_nodes, one.seconds) for one in sets.sets]
    if len(firsts) > 1:
        paints.append(paint_times("by any set-up", np.fmin.reduce(firsts), times))
    paints += [
        paint_times(f"by {one.name}", first, times)
        for one, first in zip(sets.sets, firsts, strict=True)
    ]
    return tuple(
        Paint(paint.name, paint.colours, paint.meanings, choose_most(paint.kinds[nearest]))
        for paint in paints
    )


def choose_most(kinds: UInt8[np.ndarray, "v k"]) -> UInt8[np.ndarray, "v"]:
    """Return the most frequent kind of each row."""
    counts = np.stack([(kinds == kind).sum(axis=1) for kind in range(kinds.max(initial=0) + 1)])
    return counts.argmax(axis=0).astype(np.uint8)


def paint_seen(one: VisibilitySet) -> Paint:
    """Return what one set-up sees and does not."""
    seen = one.first_nodes >= 0
    meanings = (f"not seen ({tell_share(~seen)})", f"seen ({tell_share(seen)})")
    return Paint(f"seen by {one.name}", (UNSEEN, SEEN), meanings, seen.astype(np.uint8))


def paint_together(sets: tuple[VisibilitySet, ...], seen: Bool[np.ndarray, "set cell"]) -> Paint:
    """Return who of two sees a cell, or how many of several do."""
    if len(sets) == 2:
        kinds = seen[0] + 2 * seen[1].astype(np.uint8)
        names = ("not seen", f"only by {sets[0].name}", f"only by {sets[1].name}", "by both")
        colours = (UNSEEN, *ONLY, BOTH)
    else:
        kinds = seen.sum(axis=0)
        names = ("not seen", *(f"by {n} of {len(sets)}" for n in range(1, len(sets) + 1)))
        colours = (UNSEEN, *blend(len(sets)))
    meanings = tuple(f"{name} ({tell_share(kinds == n)})" for n, name in enumerate(names))
    return Paint("seen by all together", colours, meanings, kinds.astype(np.uint8))


def paint_times(who: str, first: Float[np.ndarray, "cell"], times: int) -> Paint:
    """Return when cells were seen first, in spans that hold as many cells each."""
    seen = np.isfinite(first)
    ends = np.quantile(first[seen], np.arange(1, times + 1) / times) if seen.any() else np.zeros(1)
    ends = np.unique(ends)
    kinds = np.zeros(len(first), np.uint8)
    kinds[seen] = 1 + np.searchsorted(ends, first[seen]).clip(max=len(ends) - 1)
    starts = ("0 s", *(format_seconds(end) for end in ends[:-1]))
    spans = tuple(
        f"{start} to {format_seconds(end)}" for start, end in zip(starts, ends, strict=True)
    )
    return Paint(f"first seen {who}", (UNSEEN, *blend(len(ends))), ("not seen", *spans), kinds)


def blend(count: int) -> tuple[str, ...]:
    """Return so many colours from bright to dark."""
    shares = np.linspace(0, 1, count)[:, None]
    values = np.rint((1 - shares) * EARLY + shares * np.array(LATE)).astype(int)
    return tuple("#{:02x}{:02x}{:02x}".format(*value) for value in values)


def tell_share(chosen: Bool[np.ndarray, "cell"]) -> str:
    """Return a share of all cells as people write it."""
    return f"{100 * chosen.mean():.1f} %"
