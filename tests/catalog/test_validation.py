"""What a person wrote wrongly is answered with value, rule and cure."""

from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import Field

from catalog.validation import nearest, unknown, validate
from nodes.errors import BadInput
from nodes.parameters import Parameters


class ToyParameters(Parameters):
    width_mm: Annotated[float, Field(gt=0)]
    """Width of the gap, mm; by looking."""
    steps: int
    """Number of steps, no unit."""


GOOD = {"width_mm": 1.5, "steps": 3}


def refused(values: object) -> str:
    with pytest.raises(BadInput) as caught:
        validate(ToyParameters, values, "toy.yml")  # type: ignore[arg-type]
    return str(caught.value)


def test_allowed_values_are_returned() -> None:
    assert validate(ToyParameters, GOOD, "toy.yml") == ToyParameters(width_mm=1.5, steps=3)


def test_an_unknown_key_is_answered_with_the_nearest() -> None:
    text = refused({**GOOD, "widht_mm": 2})
    assert "toy.yml: unknown key widht_mm" in text
    assert "did you mean width_mm?" in text


def test_a_key_like_no_other_is_answered_with_all() -> None:
    assert "known: steps, width_mm" in refused({**GOOD, "zzz": 2})


@pytest.mark.parametrize("value", [0, -1.5, "wide", None, [1], float("nan"), {"a": 1}])
def test_a_forbidden_value_is_told_with_rule_meaning_and_unit(value: object) -> None:
    text = refused({**GOOD, "width_mm": value})
    assert f"toy.yml: width_mm = {value!r}" in text
    assert "rule: width_mm: Input should be" in text
    assert "Width of the gap, mm" in text
    assert "cure: " in text


def test_a_number_with_a_fraction_is_no_whole_number() -> None:
    assert "steps = 2.5" in refused({**GOOD, "steps": 2.5})


def test_a_missing_key_is_named() -> None:
    text = refused({"steps": 1})
    assert "toy.yml: width_mm is missing" in text
    assert "add a line `width_mm: ...`" in text


@pytest.mark.parametrize("values", [None, "text", 3, ["width_mm"], {1: 2}, {None: 1}, {True: 1}])
def test_what_is_no_mapping_of_names_is_refused(values: object) -> None:
    values = {**GOOD, **values} if isinstance(values, dict) else values
    assert refused(values).startswith("toy.yml: ")


@given(st.text(), st.lists(st.text()))
def test_the_nearest_name_is_one_of_the_known(name: str, known: list[str]) -> None:
    answer = nearest(name, known)
    if answer.startswith("did you mean "):
        assert answer.removeprefix("did you mean ")[:-1] in known
    else:
        assert all(other in answer for other in known)


def test_an_unknown_name_is_told_with_its_kind() -> None:
    assert str(unknown("stage", "segment", ["segment_ct"])).startswith("no stage segment\n")
    assert "did you mean segment_ct?" in str(unknown("stage", "segment", iter(["segment_ct"])))
