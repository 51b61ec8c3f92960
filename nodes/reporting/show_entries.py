"""Entries through the wall of the chest or head, as needles in 3-D and as a table."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, UInt8

from nodes.errors import BadInput
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.reporting.artefacts import Section
from nodes.reporting.colours import LOW_TO_HIGH, colour_values
from nodes.reporting.honesty import warnings_of
from nodes.reporting.marks import join_meshes, make_needle
from nodes.reporting.parameters import ShowEntriesParameters
from nodes.reporting.rendering import render_template
from nodes.reporting.scene import SCRIPTS, Mark, render_scene
from nodes.reporting.tables import render_table

if TYPE_CHECKING:
    import pandas

CLEARANCE = "bone_clearance_mm"
SKIN = ["skin_x_mm", "skin_y_mm", "skin_z_mm"]
PLEURA = ["pleura_x_mm", "pleura_y_mm", "pleura_z_mm"]
DIRECTION = ["direction_x", "direction_y", "direction_z"]
ENTRY = "entry"
AREA = "#35b597"
"""Colour of the skin where a needle may go in."""


def show_entries(
    surfaces: Surfaces,
    entry_map: LabelMap,
    entry_table: "pandas.DataFrame",
    parameters: ShowEntriesParameters,
) -> Section:
    """Show where a needle may go in, and the best entries as needles and in a table.

    Parameters
    ----------
    surfaces : named surfaces, patient LPS mm.
    entry_map : "entry" is the skin where a needle may go in.
    entry_table : one row an entry, best first: `skin_x_mm`, ... and `pleura_x_mm`, ... where the
        needle enters skin and pleura, patient LPS mm, and `bone_clearance_mm`.
    parameters : which surfaces are shown, size of the needles, scale of colours, rows.

    Returns
    -------
    A section that needs the script of the 3-D viewer. Needles have the colour of their distance to
    bone; the table leaves out their direction, which skin and pleura tell.

    Raises
    ------
    BadInput where one of those columns is missing.
    """
    refuse_missing_columns(entry_table)
    chosen = tuple(pair for pair in surfaces.meshes if pair[0] in parameters.shown)
    marks = draw_area(surfaces, entry_map, parameters) + draw_needles(entry_table, parameters)
    shown = Surfaces(chosen, surfaces.origin)
    html = render_scene(shown, marks, parameters, render_ramp(parameters))
    html += render_table(
        entry_table.drop(columns=DIRECTION, errors="ignore").head(parameters.rows),
        tell_rows(len(entry_table), parameters.rows),
        parameters.decimals,
        parameters.decimals,
    )
    warnings = warnings_of(surfaces.origin, entry_map.origin)
    return Section(parameters.title, html, warnings, SCRIPTS)


def refuse_missing_columns(entry_table: "pandas.DataFrame") -> None:
    """Raise BadInput unless the table says where each needle runs and how near to bone."""
    missing = [name for name in (*SKIN, *PLEURA, CLEARANCE) if name not in entry_table]
    if missing:
        raise BadInput(
            f"a table of entries without {', '.join(missing)}",
            "entries have places at skin and pleura and a distance to bone, in mm",
            "give the table that the search for entries made",
        )


def draw_area(
    surfaces: Surfaces, entry_map: LabelMap, parameters: ShowEntriesParameters
) -> tuple[Mark, ...]:
    """Return the triangles of the skin all of whose corners a needle may enter, as one mark."""
    from scipy.spatial import cKDTree

    skins = [mesh for name, mesh in surfaces.meshes if name in parameters.skin]
    if not skins or ENTRY not in entry_map.names or not entry_map.mask(ENTRY).any():
        return ()
    indices = np.argwhere(entry_map.mask(ENTRY)).astype(float)
    entries = transform_points(entry_map.patient_from_index, indices)
    skin = join_meshes(tuple(skins))
    distances, _ = cKDTree(entries).query(
        skin.vertices_patient_mm, distance_upper_bound=parameters.skin_reach_mm
    )
    inside = np.isfinite(distances)[skin.triangles].all(axis=1)
    area = keep_triangles(skin, inside)
    return (Mark("entry area", area, AREA, opacity=parameters.area_opacity),)


def keep_triangles(mesh: Mesh, wanted: Bool[np.ndarray, "t"]) -> Mesh:
    """Return the mesh of the wanted triangles with only the vertices that they have."""
    used, triangles = np.unique(mesh.triangles[wanted], return_inverse=True)
    return Mesh(mesh.vertices_patient_mm[used], triangles.reshape(-1, 3).astype(np.int32))


def draw_needles(
    entry_table: "pandas.DataFrame", parameters: ShowEntriesParameters
) -> tuple[Mark, ...]:
    """Return all needles as one mark with the numbers of those in the table; none for no entry."""
    if not len(entry_table):
        return ()
    skin, pleura = (entry_table[names].to_numpy(float) for names in (SKIN, PLEURA))
    outside = stand_out(skin, pleura, parameters.outside_mm)
    meshes = tuple(
        make_needle(start, end, parameters.needle_radius_mm)
        for start, end in zip(outside, pleura, strict=True)
    )
    clearances = entry_table[CLEARANCE].to_numpy(float)
    colours = colour_values(clearances, *parameters.clearance_limits_mm)
    tags = [(str(n + 1), *map(float, at)) for n, at in enumerate(outside[: parameters.rows])]
    if "number" in entry_table:
        numbers = entry_table["number"].head(parameters.rows)
        tags = [(str(number), *at) for number, (_, *at) in zip(numbers, tags, strict=True)]
    return (
        Mark("entries", join_meshes(meshes), LOW_TO_HIGH[-1], tuple(tags), paint(meshes, colours)),
    )


def stand_out(
    skin_mm: Float[np.ndarray, "n 3"], pleura_mm: Float[np.ndarray, "n 3"], length_mm: float
) -> Float[np.ndarray, "n 3"]:
    """Return the points that lie `length_mm` before the skin, on the lines to the pleura."""
    inward = pleura_mm - skin_mm
    lengths = np.linalg.norm(inward, axis=1, keepdims=True)
    return skin_mm - inward / np.maximum(lengths, 1e-9) * length_mm


def paint(meshes: tuple[Mesh, ...], colours: UInt8[np.ndarray, "n 3"]) -> UInt8[np.ndarray, "v 3"]:
    """Return the colour of each mesh for each of its vertices."""
    return np.repeat(colours, [len(mesh.vertices_patient_mm) for mesh in meshes], axis=0)


def render_ramp(parameters: ShowEntriesParameters) -> str:
    """Return the scale of colours."""
    low, high = parameters.clearance_limits_mm
    values = {"name": "distance to bone", "unit": "mm", "low": f"{low:g}", "high": f"{high:g}"}
    return render_template("ramp.html", values | {"colours": LOW_TO_HIGH})


def tell_rows(entries: int, rows: int) -> str:
    """Return what the table leaves out, or that there is none."""
    if not entries:
        return "No entry was found."
    if entries <= rows:
        return ""
    return f"The first {rows} of {entries} entries; the table in the data folder has all."
