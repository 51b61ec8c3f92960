"""Verdicts come back, and what was refused says so in the name and text of each file."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.formats.checked_plans import REFUSED, CheckedPlansFormat
from catalog.formats.plain_values import COMPUTED
from nodes.geometry.origin import Origin
from nodes.planning.artefacts import CheckedPlan, CheckedPlans
from tests.catalog.formats.hostile import ORIGINS
from tests.catalog.formats.made_plan_files import assert_equal, checked_plans, straight_plan


def checked(passed: bool, steps: int = 3) -> CheckedPlan:
    failures = () if passed else ("step 2 touches",)
    proposed = straight_plan(steps)
    return CheckedPlan(proposed, passed, failures, (), np.ones(steps), np.ones(steps))


def files_of(*plans: CheckedPlan) -> dict[str, bytes]:
    files = CheckedPlansFormat.encode(CheckedPlans(plans, Origin("a test", simulated=True)))
    return {name: content for name, content in files.items() if not name.startswith("setups/")}


def tells(content: bytes, text: str) -> bool:
    """Return whether a file says so, as text or as the codes of VTK's strings."""
    codes = " ".join(str(code) for code in text.encode())
    return text in content.decode() or codes in content.decode()


@settings(max_examples=25, deadline=None)
@given(st.lists(checked_plans(), max_size=2).map(tuple), ORIGINS)
def test_everything_comes_back(found, origin) -> None:
    value = CheckedPlans(found, origin)
    assert_equal(CheckedPlansFormat.decode(CheckedPlansFormat.encode(value)), value)


def test_files_of_a_refused_motion_say_so_in_name_and_text() -> None:
    files = files_of(checked(passed=False))
    own = {name: content for name, content in files.items() if name != "plans.json"}
    assert len(own) == 4
    for name, content in own.items():
        assert name.startswith("refused_not_a_plan_1_")
        assert tells(content, REFUSED) and tells(content, COMPUTED), name


def test_files_of_a_plan_say_that_it_is_computed_and_simulated() -> None:
    files = files_of(checked(passed=False), checked(passed=True), checked(passed=False, steps=0))
    own = [name for name in files if name.startswith("plan_2_")]
    assert len(own) == 4 and "no_plan_3_verdict.json" in files
    for name in own:
        assert not tells(files[name], REFUSED) and tells(files[name], COMPUTED)


def test_the_table_has_one_line_a_step_with_clearance_and_margin() -> None:
    lines = files_of(checked(passed=True))["plan_1_motion.csv"].decode().splitlines()
    names = lines[0].split(",")
    assert len(lines) == 4 and names[-3:] == ["clearance_mm", "stability_margin", "note"]
    assert lines[3].startswith("2,")
