import json
import re
from base64 import b64decode
from html import unescape

import numpy as np
import pytest

from nodes.geometry.origin import Origin
from nodes.geometry.sites import Sites
from nodes.reporting.show_sites import show_sites


@pytest.fixture
def sites():
    """A pose at (10, 20, 30) whose +z runs along the patient's -x, and a point."""
    pose = np.array([[0, 0, -1, 10], [0, 1, 0, 20], [1, 0, 0, 30], [0, 0, 0, 1.0]])
    origin = Origin("the case", notices=("Places were typed.",))
    return Sites(("left_start",), pose[None], ("target_1",), np.array([[-40.0, 5, 6]]), origin)


def scene_of(section):
    text = re.search(r'<script type="application/json">(.*?)</script>', section.html, re.S).group(1)
    return json.loads(text)


def points_of(scene, name):
    told = next(item for item in scene["objects"] if item["name"] == name)["vertices"]
    stored = np.frombuffer(b64decode(scene["buffers"][told["buffer"]]), "<u2").reshape(-1, 3)
    return np.array(told["origin"]) + np.array(told["step"]) * stored


def test_arrows_run_along_the_third_axis_of_their_pose(balls, sites, defaults):
    parameters = defaults("show_sites", arrow_length_mm=40)
    points = points_of(scene_of(show_sites(balls, sites, parameters)), "poses")
    assert points[:, 0].max() == pytest.approx(10, abs=0.01)
    assert points[:, 0].min() == pytest.approx(-30, abs=0.01)
    assert points[:, 1:].mean(axis=0) == pytest.approx([20, 30], abs=0.01)


def test_balls_lie_about_their_points(balls, sites, defaults):
    parameters = defaults("show_sites", ball_radius_mm=3)
    points = points_of(scene_of(show_sites(balls, sites, parameters)), "points")
    assert np.linalg.norm(points - [-40, 5, 6], axis=1) == pytest.approx(
        np.full(len(points), 3), abs=0.01
    )


def test_names_stand_at_their_places_in_view_and_table(balls, sites, defaults):
    section = show_sites(balls, sites, defaults("show_sites"))
    tags = [tag for item in scene_of(section)["objects"] for tag in item.get("tags", [])]
    assert tags == [
        {"text": "left start", "at": [10.0, 20.0, 30.0]},
        {"text": "target 1", "at": [-40.0, 5.0, 6.0]},
    ]
    text = unescape(section.html)
    for cell in ("left start", "[10.0, 20.0, 30.0]", "[-1.000, 0.000, 0.000]", "[-40.0, 5.0, 6.0]"):
        assert cell in text
    assert section.warnings[-1] == "Places were typed."


def test_a_case_without_places_shows_the_surfaces(balls, defaults):
    section = show_sites(balls, Sites(), defaults("show_sites"))
    assert [item["name"] for item in scene_of(section)["objects"]] == ["body", "left lung", "bone"]
    assert "No place is named" in section.html
