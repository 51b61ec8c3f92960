"""Shapes of robots come back as they were, and their files say where the backbone runs."""

import csv
from io import StringIO

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from catalog.formats.robot_shape import COMPUTED, RobotShapeFormat
from nodes.mechanics.shapes import Figure, RobotShape, Rod
from tests.catalog.formats.hostile import NAMES, ORIGINS, assert_same

NUMBERS = st.floats(-1e6, 1e6)


@st.composite
def rods(draw: st.DrawFn) -> Rod:
    count = draw(st.integers(1, 4))
    rows = draw(hnp.arrays(float, (count, 7), elements=NUMBERS))
    return Rod(draw(NAMES), rows[:, 0], rows[:, 1:4], rows[:, 4:], draw(st.floats(1e-3, 10)))


@st.composite
def shapes(draw: st.DrawFn) -> RobotShape:
    size = draw(st.sampled_from([0, 4]))
    figures = st.builds(Figure, st.text(), NUMBERS, st.text(), st.text())
    return RobotShape(
        kind=draw(st.sampled_from(["CRISP", "concentric tubes"])),
        status=draw(st.sampled_from(["solved", "no solution", "not converged", "unstable"])),
        reason=draw(st.text()),
        given=tuple(draw(st.lists(figures, max_size=2))),
        rods=tuple(draw(st.lists(rods(), max_size=3))),
        patient_from_tip=draw(hnp.arrays(float, (size, size), elements=NUMBERS)),
        joints_patient_mm=draw(hnp.arrays(float, (draw(st.integers(0, 2)), 3), elements=NUMBERS)),
        loads=draw(hnp.arrays(float, (draw(st.integers(0, 2)), 6), elements=NUMBERS)),
        figures=tuple(draw(st.lists(figures, max_size=3))),
        origin=draw(ORIGINS),
    )


@settings(max_examples=60, deadline=None)
@given(shapes())
def test_every_field_of_a_shape_comes_back(shape: RobotShape) -> None:
    back = RobotShapeFormat.decode(RobotShapeFormat.encode(shape))
    for name in ("kind", "status", "reason", "given", "figures", "origin"):
        assert getattr(back, name) == getattr(shape, name)
    for name in ("patient_from_tip", "joints_patient_mm", "loads"):
        assert_same(getattr(back, name), getattr(shape, name))
    assert [r.name for r in back.rods] == [r.name for r in shape.rods]
    for one, two in zip(back.rods, shape.rods, strict=True):
        assert one.outer_radius_mm == two.outer_radius_mm
        for name in ("arc_lengths_mm", "points_patient_mm", "tangents"):
            assert_same(getattr(one, name), getattr(two, name))


def test_the_csv_has_one_line_a_sample_with_all_digits(bent_shape) -> None:
    text = RobotShapeFormat.encode(bent_shape)["backbone.csv"].decode()
    rows = list(csv.DictReader(StringIO(text, newline="")))
    assert len(rows) == 5
    assert [float(row["x_mm"]) for row in rows] == [0, 1 / 3, 0.1, 7, 8]
    assert {row["name"] for row in rows} == {"tool", "snare 1"}


def test_files_say_that_a_shape_is_computed_and_not_measured(bent_shape) -> None:
    files = RobotShapeFormat.encode(bent_shape)
    assert COMPUTED in files["shape.json"].decode()
    codes = files["backbone.vtp"].decode().partition('type="String"')[2].split(">")[1].split("<")[0]
    assert COMPUTED.encode() in bytes(map(int, codes.split()))


@pytest.fixture
def bent_shape() -> RobotShape:
    from nodes.geometry.origin import Origin

    tool = np.array([[0, 0, 0], [1 / 3, 0, 1], [0.1, 0, 2]], float)
    along = np.tile([0.0, 0, 1], (3, 1))
    return RobotShape(
        "CRISP", "solved", "", (),
        (
            Rod("tool", np.arange(3.0), tool, along, 0.5),
            Rod("snare 1", np.arange(2.0), np.array([[7.0, 0, 0], [8, 0, 0]]), along[:2], 0.6),
        ),
        np.eye(4), np.zeros((1, 3)), np.zeros((0, 6)), (), Origin("a test"),
    )  # fmt: skip
