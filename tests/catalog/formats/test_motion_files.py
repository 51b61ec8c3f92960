"""Motions are shown where the robot is: needles as curves, the camera's way as a curve."""

import csv
import json
from io import StringIO
from xml.etree import ElementTree

import numpy as np
import pytest

from catalog.formats.motion_files import PIECES, write_motion
from tests.catalog.formats.made_plan_files import straight_motion, straight_plan


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    plan = straight_plan()
    return write_motion(plan.motion, plan.placed, {"more": np.array([7.0, 8, 9])}, "a note")


def arrays_of(content: bytes) -> dict[str, np.ndarray]:
    return {
        item.get("Name"): np.array((item.text or "").split(), float)
        for item in ElementTree.fromstring(content).iter("DataArray")
    }


def test_the_table_names_joint_values_and_camera(files) -> None:
    rows = list(csv.DictReader(StringIO(files["motion.csv"].decode(), newline="")))
    assert [float(row["tool_length_mm"]) for row in rows] == [200, 201, 202]
    assert [float(row["camera_z_mm"]) for row in rows] == [200, 201, 202]
    assert [float(row["more"]) for row in rows] == [7, 8, 9]
    axes = [float(rows[0][f"snare_2_axis_z_{i}"]) for i in "xyz"]
    view = [float(rows[0][f"camera_view_{i}"]) for i in "xyz"]
    assert axes == view == [0, 0, 1]


def test_needles_at_rest_are_straight_curves_from_their_entry_points(files) -> None:
    told, entries = arrays_of(files["needles.vtp"]), straight_plan().placed.setup
    points = told["Points"].reshape(-1, 3)
    for step in range(3):
        for needle in range(3):
            own = points[(told["step"] == step) & (told["needle"] == needle)]
            ways = own - entries.entry_points_patient_mm[needle]
            reach = straight_motion().lengths_mm[step, needle]
            assert len(own) == (2 * PIECES + 2 if needle == 0 else PIECES + 1)
            assert np.abs(ways[:, :2]).max() < 1e-9
            assert ways[[0, -1], 2] == pytest.approx([0, reach], abs=1e-9)
    assert len(told["offsets"]) == 9
    assert set(told["outer_radius_mm"]) == {1.27 / 2}


def test_the_way_of_the_camera_is_a_curve_for_slicer(files) -> None:
    (markup,) = json.loads(files["tip_path.mrk.json"])["markups"]
    assert markup["type"] == "Curve" and markup["coordinateSystem"] == "LPS"
    places = [point["position"] for point in markup["controlPoints"]]
    assert places == [[0, 0, 200], [0, 0, 201], [0, 0, 202]]


def test_a_motion_that_no_robot_can_make_is_written_without_curves() -> None:
    plan = straight_plan()
    short = straight_motion()
    lengths = np.array(short.lengths_mm)
    lengths[:, 0] = 50.0  # the grasps would lie before the entry point
    motion = type(short)(short.orientations, lengths, short.wrenches, short.patient_from_camera)
    made = write_motion(motion, plan.placed, {}, "refused")
    assert len(arrays_of(made["needles.vtp"])["offsets"]) == 0
    assert "motion.csv" in made


def test_no_motion_is_no_file() -> None:
    plan = straight_plan(0)
    assert write_motion(plan.motion, plan.placed, {}, "x") == {}
