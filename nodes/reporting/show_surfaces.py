"""Surfaces that turn in a page."""

from nodes.geometry.meshes import Mesh, Surfaces
from nodes.reporting.artefacts import Section
from nodes.reporting.colours import colour_names, words
from nodes.reporting.embedding import add_indices, add_points, embed_json
from nodes.reporting.honesty import warnings_of
from nodes.reporting.parameters import ShowSurfacesParameters
from nodes.reporting.rendering import render_template


def show_surfaces(surfaces: Surfaces, parameters: ShowSurfacesParameters) -> Section:
    """Show surfaces in a 3-D view that turns, zooms and hides parts.

    Parameters
    ----------
    surfaces : named surfaces, patient LPS mm; empty ones are named below the view.
    parameters : title, caption, which surfaces are translucent.

    Returns
    -------
    A section that needs the script "viewer3d".
    """
    empty = [words(name) for name, mesh in surfaces.meshes if not len(mesh.triangles)]
    values = {
        "title": parameters.title,
        "caption": parameters.caption,
        "empty": empty,
        "scene": embed_json(build_scene(surfaces, parameters)),
    }
    html = render_template("surfaces.html", values)
    return Section(parameters.title, html, warnings_of(surfaces.origin), ("viewer3d",))


def build_scene(surfaces: Surfaces, parameters: ShowSurfacesParameters) -> dict[str, object]:
    """Return the scene that the 3-D viewer reads (its format: assets/README.md)."""
    buffers: list[str] = []
    colours = colour_names(tuple(name for name, _ in surfaces.meshes))
    objects = [
        build_object(buffers, name, mesh, colour, parameters)
        for (name, mesh), colour in zip(surfaces.meshes, colours, strict=True)
        if len(mesh.triangles)
    ]
    return {"format": "tendril-scene", "version": 1, "objects": objects, "buffers": buffers}


def build_object(
    buffers: list[str], name: str, mesh: Mesh, colour: str, parameters: ShowSurfacesParameters
) -> dict[str, object]:
    """Return one mesh of the scene; its arrays go to `buffers`."""
    return {
        "kind": "mesh",
        "name": words(name),
        "colour": colour,
        "opacity": parameters.translucent_opacity if name in parameters.translucent else 1.0,
        "vertices": add_points(buffers, mesh.vertices_patient_mm),
        "triangles": add_indices(buffers, mesh.triangles),
    }
