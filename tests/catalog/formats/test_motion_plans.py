"""Motions come back digit by digit, and nothing unchecked is called a plan."""

from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.formats.motion_plans import NOT_CHECKED, MotionPlansFormat
from nodes.geometry.origin import Origin
from nodes.planning.artefacts import MotionPlans
from tests.catalog.formats.hostile import ORIGINS
from tests.catalog.formats.made_plan_files import assert_equal, plans, straight_plan


@settings(max_examples=25, deadline=None)
@given(st.lists(plans(), max_size=2).map(tuple), ORIGINS)
def test_everything_comes_back(found, origin) -> None:
    value = MotionPlans(found, origin)
    assert_equal(MotionPlansFormat.decode(MotionPlansFormat.encode(value)), value)


def test_one_setup_of_many_plans_is_written_once() -> None:
    one = straight_plan()
    files = MotionPlansFormat.encode(
        MotionPlans((one, replace(one, goal="goal 2"), straight_plan(0)), Origin("a test"))
    )
    assert [name for name in files if name.endswith(".yml")] == ["setups/setup_1.yml"]


def test_no_file_of_an_unchecked_motion_is_called_a_plan() -> None:
    files = MotionPlansFormat.encode(MotionPlans((straight_plan(),), Origin("a test")))
    shown = {name: content for name, content in files.items() if not name.startswith("setups/")}
    assert not any("plan" in name for name in shown)
    for name, content in shown.items():
        told = content.decode()
        codes = " ".join(str(code) for code in NOT_CHECKED.encode())
        assert NOT_CHECKED in told or codes in told, name
