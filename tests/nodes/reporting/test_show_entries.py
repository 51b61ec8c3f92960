import json
import re
from base64 import b64decode
from dataclasses import replace

import numpy as np
import pandas
import pytest

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from nodes.reporting.show_entries import show_entries

COLUMNS = ["number", "window", *[f"{p}_{a}_mm" for p in ("skin", "pleura") for a in "xyz"]]


@pytest.fixture
def entry_map(balls):
    """Entries are the skin of the body, a ball of 100 mm, on its right side."""
    patient_from_index = np.diag([5.0, 5, 5, 1])
    patient_from_index[:3, 3] = -110
    centres = np.moveaxis(np.indices((45, 45, 45)), 0, -1) * 5.0 - 110
    skin = np.abs(np.linalg.norm(centres, axis=-1) - 100) < 4
    voxels = np.where(skin & (centres[..., 0] < -60), 1, 0).astype(np.uint8)
    origin = Origin("made up", notices=("The heart is no label.",))
    return LabelMap(voxels, patient_from_index, ("entry", "corridor"), origin)


@pytest.fixture
def entry_table():
    rows = [
        (1, "right 5", -100.0, 0.0, 10.0, -70.0, 0.0, 10.0, 12.0),
        (2, "right 6", 0.0, -90.0, -20.0, 0.0, -60.0, -20.0, 0.0),
        (3, "right 7", 0.0, -90.0, 20.0, 0.0, -60.0, 20.0, float("nan")),
    ]
    return pandas.DataFrame(rows, columns=[*COLUMNS, "bone_clearance_mm"])


def scene_of(section):
    text = re.search(r'<script type="application/json">(.*?)</script>', section.html, re.S).group(1)
    return json.loads(text)


def read(scene, told, kind):
    stored = np.frombuffer(b64decode(scene["buffers"][told["buffer"]]), kind).reshape(-1, 3)
    return np.array(told.get("origin", 0)) + np.array(told.get("step", 1)) * stored


def test_needles_run_from_outside_the_skin_to_the_pleura(balls, entry_map, entry_table, defaults):
    parameters = defaults("show_entries", outside_mm=25)
    scene = scene_of(show_entries(balls, entry_map, entry_table, parameters))
    needles = scene["objects"][-1]
    points = read(scene, needles["vertices"], "<u2").reshape(3, -1, 3)
    radius = parameters.needle_radius_mm + 0.02
    for needle, axis, ends in zip(
        points, (0, 1, 1), ((-125, -70), (-115, -60), (-115, -60)), strict=True
    ):
        assert needle[:, axis].min() == pytest.approx(ends[0], abs=0.02)
        assert needle[:, axis].max() == pytest.approx(ends[1], abs=0.02)
        middle = np.delete(needle, axis, axis=1)
        assert np.ptp(middle, axis=0).max() <= 2 * radius
    assert [tag["text"] for tag in needles["tags"]] == ["1", "2", "3"]
    assert needles["tags"][0]["at"] == [-125.0, 0.0, 10.0]


def test_colours_tell_the_distance_to_bone(balls, entry_map, entry_table, defaults):
    scene = scene_of(show_entries(balls, entry_map, entry_table, defaults("show_entries")))
    colours = read(scene, scene["objects"][-1]["vertex_colours"], "|u1").reshape(3, -1, 3)
    assert np.ptp(colours, axis=1).max() == 0
    plenty, none, unknown = colours[:, 0]
    assert plenty[1] > plenty[0] + 50 and none[0] > none[1] + 50 and np.ptp(unknown) == 0


def test_the_table_has_the_first_rows_and_the_view_has_all(balls, entry_map, entry_table, defaults):
    section = show_entries(balls, entry_map, entry_table, defaults("show_entries", rows=2))
    assert "right 6" in section.html and "right 7" not in section.html
    assert "The first 2 of 3 entries" in section.html
    scene = scene_of(section)
    needles = scene["objects"][-1]
    assert len(read(scene, needles["vertices"], "<u2")) % 3 == 0 and len(needles["tags"]) == 2
    assert (
        "The first"
        not in show_entries(balls, entry_map, entry_table, defaults("show_entries")).html
    )


def test_only_the_wanted_surfaces_are_shown(balls, entry_map, entry_table, defaults):
    scene = scene_of(
        show_entries(balls, entry_map, entry_table, defaults("show_entries", shown=["bone"]))
    )
    assert [item["name"] for item in scene["objects"]] == ["bone", "entry area", "entries"]


def test_the_entry_area_is_the_skin_that_the_map_names(balls, entry_map, entry_table, defaults):
    section = show_entries(balls, entry_map, entry_table, defaults("show_entries"))
    scene = scene_of(section)
    area = next(item for item in scene["objects"] if item["name"] == "entry area")
    points = read(scene, area["vertices"], "<u2")
    assert np.linalg.norm(points, axis=1) == pytest.approx(np.full(len(points), 100), abs=0.1)
    assert points[:, 0].max() < -60 + 5 and points[:, 0].min() < -99
    stored = np.frombuffer(b64decode(scene["buffers"][area["triangles"]["buffer"]]), "<u2")
    corners = points[stored.reshape(-1, 3)]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area_mm2 = np.linalg.norm(sides, axis=1).sum() / 2
    # A ball's cap has the area 2 pi r h; whole triangles of at most 14 mm lie inside of it.
    caps_mm2 = [2 * np.pi * 100 * (40 - short) for short in (14, 0)]
    assert caps_mm2[0] < area_mm2 < caps_mm2[1]
    assert "The heart is no label." in section.warnings


def test_no_entry_area_is_drawn_where_none_is(balls, entry_map, entry_table, defaults):
    nowhere = replace(entry_map, voxels=np.zeros_like(entry_map.voxels))
    scene = scene_of(show_entries(balls, nowhere, entry_table, defaults("show_entries")))
    assert "entry area" not in [item["name"] for item in scene["objects"]]


def test_no_entry_is_said_and_not_an_error(balls, entry_map, entry_table, defaults):
    section = show_entries(balls, entry_map, entry_table.head(0), defaults("show_entries"))
    assert "No entry was found." in section.html
    assert "entries" not in [item["name"] for item in scene_of(section)["objects"]]


def test_a_table_without_places_is_refused(balls, entry_map, entry_table, defaults):
    with pytest.raises(BadInput, match="pleura_z_mm"):
        show_entries(
            balls, entry_map, entry_table.drop(columns="pleura_z_mm"), defaults("show_entries")
        )
