import json
import re
from base64 import b64decode
from html import unescape

import numpy as np

from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.origin import Origin
from nodes.reporting.show_surfaces import show_surfaces


def scene_of(section):
    text = re.search(r'<script type="application/json">(.*?)</script>', section.html, re.S).group(1)
    return json.loads(text)


def test_the_scene_holds_every_surface_as_it_is(balls, defaults):
    section = show_surfaces(balls, defaults("show_surfaces"))
    scene = scene_of(section)
    assert [item["name"] for item in scene["objects"]] == ["body", "left lung", "bone"]
    for item, (_, mesh) in zip(scene["objects"], balls.meshes, strict=True):
        told = item["vertices"]
        stored = np.frombuffer(b64decode(scene["buffers"][told["buffer"]]), "<u2").reshape(-1, 3)
        points = np.array(told["origin"]) + np.array(told["step"]) * stored
        assert np.abs(points - mesh.vertices_patient_mm).max() < 0.01
        indices = np.frombuffer(b64decode(scene["buffers"][item["triangles"]["buffer"]]), "<u2")
        assert np.array_equal(indices.reshape(-1, 3), mesh.triangles)


def test_surfaces_have_the_opacity_of_their_name(balls, defaults):
    opacities = {"body": 0.3, "bone": 0.0}
    scene = scene_of(show_surfaces(balls, defaults("show_surfaces", opacities=opacities)))
    assert [item["opacity"] for item in scene["objects"]] == [0.3, 1.0, 1.0]
    assert [item.get("visible", True) for item in scene["objects"]] == [True, True, False]


def test_a_lung_inside_a_body_is_seen_by_default(balls, defaults):
    opacities = defaults("show_surfaces").opacities
    assert opacities["body"] < opacities["left_lung"] < 1 and "airway" not in opacities


def test_the_section_warns_of_what_is_simulated(balls, defaults):
    section = show_surfaces(balls, defaults("show_surfaces"))
    assert section.warnings == ("simulated: three balls", "Balls are not anatomy.")
    assert section.scripts == ("viewer3d",)


def test_an_empty_surface_is_named_and_not_drawn(defaults):
    nothing = Mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    section = show_surfaces(
        Surfaces((("left_lung", nothing),), Origin("nothing")), defaults("show_surfaces")
    )
    assert scene_of(section)["objects"] == []
    assert "Without surface: left lung." in unescape(section.html)
