"""A selection is what a person would mark in the picture of the pipeline."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodes.errors import BadInput
from pipelines.selection import Selection, upstream
from pipelines.stage import ACCOUNT, Stage

#   a --> b --> d --> page (takes the account, and so all)
#     \-> c ----/          e stands alone
STAGES = (
    Stage("t.a", ["input"], ["a1", "a2"]),
    Stage("t.b", ["a1"], ["b1"]),
    Stage("t.c", {"x": "a2"}, ["c1"]),
    Stage("t.e", [], ["e1"]),
    Stage("t.d", ["b1", "c1"], ["d1"]),
    Stage("t.page", ["d1", ACCOUNT], ["page"]),
)
NAMES = [stage.name for stage in STAGES]


def test_nothing_said_is_everything() -> None:
    assert Selection().choose(STAGES) == set(NAMES)


@pytest.mark.parametrize(
    ("selection", "chosen"),
    [
        (Selection(first="b"), "b d page"),
        (Selection(first="e"), "e page"),
        (Selection(last="d"), "a b c d"),
        (Selection(last="a"), "a"),
        (Selection(last="page"), "a b c e d page"),
        (Selection(first="b", last="d"), "b d"),
        (Selection(first="a", last="c"), "a c"),
        (Selection(first="c", last="c"), "c"),
        (Selection(only="b"), "b"),
        (Selection(only="b", forced=("b",)), "b"),
    ],
)
def test_a_selection_chooses(selection: Selection, chosen: str) -> None:
    assert selection.choose(STAGES) == set(chosen.split())


@pytest.mark.parametrize("field", ["first", "last", "only"])
def test_a_name_that_is_no_stage_is_answered_with_the_nearest(field: str) -> None:
    with pytest.raises(BadInput, match=r"did you mean page\?"):
        Selection(**{field: "pgae"}).choose(STAGES)


def test_a_forced_name_must_be_a_stage() -> None:
    with pytest.raises(BadInput, match="no stage x"):
        Selection(forced=("a", "x")).choose(STAGES)


@pytest.mark.parametrize(("first", "last"), [("d", "b"), ("b", "c"), ("e", "d")])
def test_a_selection_of_nothing_is_refused(first: str, last: str) -> None:
    with pytest.raises(BadInput, match=f"no stage from {first} to {last}"):
        Selection(first=first, last=last).choose(STAGES)


@st.composite
def pipelines(draw: st.DrawFn) -> tuple[Stage, ...]:
    """Draw up to 7 stages, each with any of the earlier ones' outputs, some with the account."""
    stages: list[Stage] = []
    for n in range(draw(st.integers(1, 7))):
        before = [f"d{m}" for m in range(n)]
        inputs = draw(st.lists(st.sampled_from([*before, ACCOUNT]), unique=True, max_size=3))
        stages.append(Stage(f"t.s{n}", inputs, [f"d{n}"]))
    return tuple(stages)


def paths_closed(stages: tuple[Stage, ...]) -> set[tuple[str, str]]:
    """Return all pairs (earlier, later) where the later needs the earlier, by trying every edge."""
    pairs = {
        (one.name, two.name)
        for one, two in itertools.combinations(stages, 2)
        if ACCOUNT in two.inputs or set(one.outputs) & set(two.inputs)
    }
    while more := {(a, d) for a, b in pairs for c, d in pairs if b == c} - pairs:
        pairs |= more
    return pairs


@given(pipelines())
def test_from_and_to_follow_every_path_and_no_other(stages: tuple[Stage, ...]) -> None:
    pairs = paths_closed(stages)
    for stage in stages:
        above = {a for a, b in pairs if b == stage.name}
        below = {b for a, b in pairs if a == stage.name}
        assert upstream(stages, stage) == above
        assert Selection(last=stage.name).choose(stages) == above | {stage.name}
        assert Selection(first=stage.name).choose(stages) == below | {stage.name}
