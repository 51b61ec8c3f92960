"""The scene that the 3-D viewer reads (its format: assets/README.md), and the view around it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt8

from nodes.geometry.meshes import Mesh, Surfaces
from nodes.reporting.colours import colour_names, words
from nodes.reporting.embedding import add_array, add_indices, add_points, embed_json
from nodes.reporting.parameters import ShowSurfacesParameters
from nodes.reporting.rendering import render_template

SCRIPTS = ("viewer3d",)
"""What the 3-D viewer needs."""


@dataclass(frozen=True)
class Paint:
    """Colours of a surface that tell something; a reader chooses among a surface's paints.

    Parameters
    ----------
    name : what the colours tell.
    colours : "#rrggbb" of each kind.
    meanings : what each kind is, as the key says it.
    kinds : (v,) of each vertex, as place in `colours`.
    """

    name: str
    colours: tuple[str, ...]
    meanings: tuple[str, ...]
    kinds: UInt8[np.ndarray, "v"]


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
    paints : what its colours may tell; then `colour` stands in the list of parts alone.
    choice : the only choice of the scene with which it is shown, or None for all.
    """

    name: str
    mesh: Mesh
    colour: str
    tags: tuple[tuple[str, float, float, float], ...] = ()
    vertex_colours: UInt8[np.ndarray, "v 3"] | None = None
    opacity: float = 1.0
    shine: bool = False
    paints: tuple[Paint, ...] = ()
    choice: int | None = None


@dataclass(frozen=True)
class MovingTubes:
    """Tubes about curves that have another shape in each step of a motion.

    Parameters
    ----------
    points_patient_mm : (step, curve, point, 3) along the curves, of which each is one tube.
    choice, shine : as a mark's.
    """

    name: str
    points_patient_mm: Float[np.ndarray, "step curve point 3"]
    radius_mm: float
    colour: str
    choice: int | None = None
    shine: bool = False


@dataclass(frozen=True)
class MovingBody:
    """A rigid mesh that has another place in each step of a motion.

    Parameters
    ----------
    mesh : in the body's own frame, mm.
    patient_from_body : (step, 4, 4).
    opacity, choice : as a mark's.
    """

    name: str
    mesh: Mesh
    patient_from_body: Float[np.ndarray, "step 4 4"]
    colour: str
    opacity: float = 1.0
    choice: int | None = None


@dataclass(frozen=True)
class Choice:
    """One of several robots or motions of a scene; the reader chooses.

    Parameters
    ----------
    name : as the reader chooses it.
    steps : what is said at each step of its motion; empty where nothing moves.
    """

    name: str
    steps: tuple[str, ...] = ()


Shown = Mark | MovingTubes | MovingBody


def render_scene(
    surfaces: Surfaces,
    marks: tuple[Shown, ...],
    parameters: ShowSurfacesParameters,
    below: str = "",
    choices: tuple[Choice, ...] = (),
    above: str = "",
) -> str:
    """Return the HTML of a 3-D view of surfaces and marks.

    Parameters
    ----------
    surfaces : named surfaces; empty ones are named below the view.
    marks : what is shown with them, at rest or moving.
    parameters : caption, opacities.
    below, above : finished fragments below and above the list of parts.
    choices : what the reader may choose; the marks of all others are hidden.
    """
    empty = [words(name) for name, mesh in surfaces.meshes if not len(mesh.triangles)]
    values = {
        "caption": parameters.caption,
        "title": parameters.title,
        "empty": empty,
        "below": below,
        "above": above,
        "scene": embed_json(build_scene(surfaces, parameters, marks, choices)),
    }
    return render_template("surfaces.html", values)


def build_scene(
    surfaces: Surfaces,
    parameters: ShowSurfacesParameters,
    marks: tuple[Shown, ...] = (),
    choices: tuple[Choice, ...] = (),
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
    objects += [item for mark in marks if (item := build_shown(buffers, mark))]
    scene = {"format": "tendril-scene", "version": 1, "objects": objects, "buffers": buffers}
    if choices:
        scene["choices"] = [{"name": one.name, "steps": list(one.steps)} for one in choices]
    return scene


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


def build_shown(buffers: list[str], shown: Shown) -> dict[str, object]:
    """Return one mark or moving thing of the scene; nothing for an empty one."""
    if isinstance(shown, MovingTubes):
        item = build_tubes(buffers, shown)
    elif isinstance(shown, MovingBody):
        item = build_body(buffers, shown)
    elif len(shown.mesh.triangles):
        item = build_mark(buffers, shown)
    else:
        return {}
    return item if shown.choice is None else item | {"choice": shown.choice}


def build_mark(buffers: list[str], mark: Mark) -> dict[str, object]:
    """Return one mark of the scene with its texts and paints."""
    item = build_object(buffers, mark.name, mark.mesh, mark.colour)
    item |= {"mark": True, "opacity": mark.opacity, "shine": mark.shine}
    item["tags"] = [{"text": text, "at": list(at)} for text, *at in mark.tags]
    if mark.vertex_colours is not None:
        item["vertex_colours"] = add_array(buffers, mark.vertex_colours, "uint8")
    if mark.paints:
        item["paints"] = [
            {
                "name": paint.name,
                "colours": list(paint.colours),
                "meanings": list(paint.meanings),
                "kinds": add_array(buffers, paint.kinds[:, None], "uint8"),
            }
            for paint in mark.paints
        ]
    return item


def build_tubes(buffers: list[str], tubes: MovingTubes) -> dict[str, object]:
    """Return one part of the scene that is made of moving tubes."""
    _, curves, points, _ = tubes.points_patient_mm.shape
    return {
        "kind": "tube",
        "name": tubes.name,
        "colour": tubes.colour,
        "mark": True,
        "shine": tubes.shine,
        "radius": tubes.radius_mm,
        "curves": curves,
        "points_each": points,
        "points": add_points(buffers, tubes.points_patient_mm.reshape(-1, 3)),
    }


def build_body(buffers: list[str], body: MovingBody) -> dict[str, object]:
    """Return one moving rigid mesh of the scene."""
    poses = body.patient_from_body[:, :3].reshape(-1, 12)
    item = build_object(buffers, body.name, body.mesh, body.colour)
    return item | {
        "kind": "ride",
        "mark": True,
        "opacity": body.opacity,
        "poses": add_array(buffers, poses, "float32"),
    }
