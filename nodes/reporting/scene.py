"""The scene that the 3-D viewer reads (its format: assets/README.md), and the view around it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import UInt8

from nodes.geometry.meshes import Mesh, Surfaces
from nodes.reporting.colours import colour_names, words
from nodes.reporting.embedding import add_array, add_indices, add_points, embed_json
from nodes.reporting.parameters import ShowSurfacesParameters
from nodes.reporting.rendering import render_template

SCRIPTS = ("viewer3d",)
"""What the 3-D viewer needs."""


@dataclass(frozen=True)
class Mark:
    """Something that is no surface of the anatomy, shown with it.

    Parameters
    ----------
    name : as people read it.
    mesh : its shape, patient LPS mm.
    colour : "#rrggbb".
    tags : texts that stand at places, as (text, x, y, z) in patient LPS mm.
    vertex_colours : (v, 3) red, green, blue, or None for `colour` everywhere.
    opacity : at first, 0 to 1.
    shine : True where it is seen faintly through what hides it.
    """

    name: str
    mesh: Mesh
    colour: str
    tags: tuple[tuple[str, float, float, float], ...] = ()
    vertex_colours: UInt8[np.ndarray, "v 3"] | None = None
    opacity: float = 1.0
    shine: bool = False


def render_scene(
    surfaces: Surfaces, marks: tuple[Mark, ...], parameters: ShowSurfacesParameters, below: str = ""
) -> str:
    """Return the HTML of a 3-D view of surfaces and marks.

    Parameters
    ----------
    surfaces : named surfaces; empty ones are named below the view.
    marks : what is shown with them.
    parameters : caption, opacities.
    below : finished fragment that stands below the list of parts.
    """
    empty = [words(name) for name, mesh in surfaces.meshes if not len(mesh.triangles)]
    values = {
        "caption": parameters.caption,
        "title": parameters.title,
        "empty": empty,
        "below": below,
        "scene": embed_json(build_scene(surfaces, parameters, marks)),
    }
    return render_template("surfaces.html", values)


def build_scene(
    surfaces: Surfaces, parameters: ShowSurfacesParameters, marks: tuple[Mark, ...] = ()
) -> dict[str, object]:
    """Return the scene: every surface that has triangles, then the marks."""
    buffers: list[str] = []
    colours = colour_names(tuple(name for name, _ in surfaces.meshes))
    objects = []
    for (name, mesh), colour in zip(surfaces.meshes, colours, strict=True):
        if len(mesh.triangles):
            opacity = parameters.opacities.get(name, 1.0)
            item = build_object(buffers, words(name), mesh, colour)
            objects.append(item | describe_opacity(opacity))
    objects += [build_mark(buffers, mark) for mark in marks if len(mark.mesh.triangles)]
    return {"format": "tendril-scene", "version": 1, "objects": objects, "buffers": buffers}


def describe_opacity(opacity: float) -> dict[str, object]:
    """Return how an object appears at first; what is hidden is opaque when it is switched on."""
    return {"opacity": opacity} if opacity > 0 else {"opacity": 1.0, "visible": False}


def build_object(buffers: list[str], name: str, mesh: Mesh, colour: str) -> dict[str, object]:
    """Return one mesh of the scene; its arrays go to `buffers`."""
    return {
        "kind": "mesh",
        "name": name,
        "colour": colour,
        "vertices": add_points(buffers, mesh.vertices_patient_mm),
        "triangles": add_indices(buffers, mesh.triangles),
    }


def build_mark(buffers: list[str], mark: Mark) -> dict[str, object]:
    """Return one mark of the scene with its texts."""
    item = build_object(buffers, mark.name, mark.mesh, mark.colour)
    item |= {"mark": True, "opacity": mark.opacity, "shine": mark.shine}
    item["tags"] = [{"text": text, "at": list(at)} for text, *at in mark.tags]
    if mark.vertex_colours is not None:
        item["vertex_colours"] = add_array(buffers, mark.vertex_colours, "uint8")
    return item
