"""Places that a person marked in the patient, in 3-D among the surfaces and as a table."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from nodes.geometry.meshes import Surfaces
from nodes.geometry.sites import Sites
from nodes.reporting.artefacts import Section
from nodes.reporting.colours import words
from nodes.reporting.honesty import warnings_of
from nodes.reporting.marks import join_meshes, make_arrow, make_ball
from nodes.reporting.parameters import ShowSitesParameters
from nodes.reporting.scene import SCRIPTS, Mark, render_scene
from nodes.reporting.tables import render_table

if TYPE_CHECKING:
    import pandas

POSES, POINTS = "#d55e00", "#d6007f"
"""Colours of poses and points; no anatomy has them."""


def show_sites(surfaces: Surfaces, sites: Sites, parameters: ShowSitesParameters) -> Section:
    """Show surfaces, each named pose as an arrow along its +z axis, and each point as a ball.

    Parameters
    ----------
    surfaces : named surfaces, patient LPS mm.
    sites : named poses and points, patient LPS mm; there may be none.
    parameters : title, caption, opacities, size of arrows and balls.

    Returns
    -------
    A section that needs the script of the 3-D viewer.
    """
    marks = draw_poses(sites, parameters) + draw_points(sites, parameters)
    caption = "" if sites.names else "No place is named in this case."
    table = render_table(tabulate_sites(sites), caption, 1, 1)
    html = render_scene(surfaces, marks, parameters) + table
    return Section(parameters.title, html, warnings_of(surfaces.origin, sites.origin), SCRIPTS)


def draw_poses(sites: Sites, parameters: ShowSitesParameters) -> tuple[Mark, ...]:
    """Return all poses as one mark; none where there is no pose."""
    if not sites.pose_names:
        return ()
    arrows = tuple(
        make_arrow(pose[:3, 3], pose[:3, 2], parameters.arrow_length_mm, parameters.arrow_radius_mm)
        for pose in sites.patient_from_site
    )
    places = sites.patient_from_site[:, :3, 3]
    tags = tag_places(sites.pose_names, places)
    return (Mark("poses", join_meshes(arrows), POSES, tags, shine=True),)


def draw_points(sites: Sites, parameters: ShowSitesParameters) -> tuple[Mark, ...]:
    """Return all points as one mark; none where there is no point."""
    if not sites.point_names:
        return ()
    balls = tuple(make_ball(point, parameters.ball_radius_mm) for point in sites.points_patient_mm)
    tags = tag_places(sites.point_names, sites.points_patient_mm)
    return (Mark("points", join_meshes(balls), POINTS, tags, shine=True),)


def tag_places(
    names: tuple[str, ...], places: Float[np.ndarray, "n 3"]
) -> tuple[tuple[str, float, float, float], ...]:
    """Return each name in words at its place."""
    return tuple(
        (words(name), *map(float, place)) for name, place in zip(names, places, strict=True)
    )


def tabulate_sites(sites: Sites) -> "pandas.DataFrame":
    """Return one row a site: its name, what it is, its place and, of a pose, its +z axis."""
    import pandas

    axes = [f"[{', '.join(f'{n:.3f}' for n in pose[:3, 2])}]" for pose in sites.patient_from_site]
    kinds = ["pose"] * len(sites.pose_names) + ["point"] * len(sites.point_names)
    columns = {"name": [words(name) for name in sites.names], "kind": kinds}
    for axis, values in zip("xyz", sites.places_patient_mm.T, strict=True):
        columns[f"place_{axis}_mm"] = list(map(float, values))
    columns["+z axis"] = [*axes, *([None] * len(sites.point_names))]
    return pandas.DataFrame(columns)
