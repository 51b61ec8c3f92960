"""Setups in a patient come back digit by digit, and are read as people write them."""

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.formats.placed_setups import LONGEST_MM, SHORTEST_MM, TILT_DEG, PlacedSetupsFormat
from nodes.errors import BadInput
from nodes.planning.artefacts import PlacedSetups
from tests.catalog.formats.hostile import ORIGINS
from tests.catalog.formats.made_plan_files import assert_equal, placed_setups

NEEDLE = {"material": "nitinol", "inner_diameter_mm": 0.84, "outer_diameter_mm": 1.02}
WRITTEN = {
    "robot": "crisp",
    "needles": [NEEDLE, NEEDLE],
    "entry_points_patient_mm": [[0, 0, 0], [100, 0, 110]],
    "snares": [{"needle": 1, "grasp_mm": 10, "measured_from": "tip", "joint": "rigid"}],
    "field_of_view_deg": 80,
    "start": {
        "lengths_mm": [120, 100],
        "orientations": [{"direction": [0, 0, 1]}, {"direction": [-2, 0, 0]}],
    },
}
LIMITS = {
    "axes": [[0, 0, 2], [-1, 0, 0]],
    "largest_tilts_deg": [90, 45],
    "shortest_mm": [40, 20],
    "longest_mm": [150, 140],
    "entries": [3, 8],
}


def read(*written: dict, **files: bytes):
    named = {f"left {n}.yml": yaml.safe_dump(each).encode() for n, each in enumerate(written)}
    return PlacedSetupsFormat.decode(named | files)


def refused(written: dict) -> str:
    with pytest.raises(BadInput) as caught:
        read(written)
    return str(caught.value)


@settings(max_examples=25, deadline=None)
@given(st.lists(placed_setups(), max_size=2).map(tuple), ORIGINS)
def test_everything_comes_back_from_the_store(setups, origin) -> None:
    value = PlacedSetups(setups, origin)
    assert_equal(PlacedSetupsFormat.decode(PlacedSetupsFormat.encode(value)), value)


def test_no_file_means_no_setups() -> None:
    assert PlacedSetupsFormat.decode({}).setups == ()


def test_what_a_person_writes_is_read_and_called_by_its_file() -> None:
    (placed,) = read(WRITTEN | LIMITS).setups
    assert placed.name == "left 0" and placed.entries == (3, 8)
    np.testing.assert_allclose(placed.axes, [[0, 0, 1], [-1, 0, 0]])
    np.testing.assert_allclose(placed.largest_tilts_rad, [np.pi / 2, np.pi / 4])
    np.testing.assert_allclose(
        placed.start.patient_from_entry[:, :, 2], [[0, 0, 1], [-1, 0, 0]], atol=1e-15
    )
    assert placed.shortest_mm.tolist() == [40, 20] and placed.longest_mm.tolist() == [150, 140]
    assert not any("assumed" in notice for notice in placed.setup.origin.notices)


def test_limits_that_are_left_out_are_assumed_and_told() -> None:
    value = read(WRITTEN)
    (placed,) = value.setups
    np.testing.assert_allclose(placed.axes, [[0, 0, 1], [-1, 0, 0]], atol=1e-15)
    np.testing.assert_allclose(placed.largest_tilts_rad, np.radians(TILT_DEG))
    assert placed.shortest_mm.tolist() == [SHORTEST_MM + 10, SHORTEST_MM]
    assert placed.longest_mm.tolist() == [LONGEST_MM, LONGEST_MM]
    assert sum("left 0: assumed" in notice for notice in value.origin.notices) == 4


def test_other_files_are_left_out_and_counted() -> None:
    value = read(WRITTEN, **{"._x.yml": b"\0", "notes.txt": b"x"})
    assert len(value.setups) == 1
    assert "2 files that hold no setup were left out" in value.origin.notices


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"start": None}, "setup left 0: start = None"),
        ({"start": {"lengths_mm": [1]}}, "orientations is missing"),
        ({"start": {**WRITTEN["start"], "lengths_mm": [120]}}, "1 lengths and 2 orientations"),
        ({"axes": [[0, 0, 1]]}, "1 axes and 2 needles"),
        ({"axes": [[0, 0, 0], [0, 0, 1]]}, "a direction is not zero"),
        ({"largest_tilts_rad": [1, 1]}, "written once"),
        ({"largest_tilts_deg": [-1, 10]}, "tilts by at most -1 degrees"),
        ({"shortest_mm": [160, 20]}, "between 160 and 150 mm"),
        ({"shortest_mm": [0, 20]}, "between 0 and 150 mm"),
        ({"largest_tilt_deg": [1, 1]}, "did you mean largest_tilts_deg?"),
        ({"robot": "concentric_tubes"}, "what is asked for"),
    ],
)
def test_wrong_lines_are_answered_with_the_setup_and_the_rule(change, told) -> None:
    message = refused(WRITTEN | LIMITS | change)
    assert told in message and "left 0" in message


def test_a_folder_without_a_setup_is_refused() -> None:
    with pytest.raises(BadInput, match="no setup in them"):
        PlacedSetupsFormat.decode({"a.txt": b""})


def test_two_setups_of_one_name_are_refused() -> None:
    content = yaml.safe_dump(WRITTEN).encode()
    with pytest.raises(BadInput, match="two setups are called a"):
        PlacedSetupsFormat.decode({"x/a.yml": content, "y/a.yml": content})
