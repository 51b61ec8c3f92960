"""Records come back as they were; what JSON cannot say is refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from catalog.formats.record import RecordFormat
from tests.catalog.formats.hostile import TEXTS

LEAVES = (
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False)
)
VALUES = st.recursive(
    LEAVES | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=8,
)


@given(st.dictionaries(TEXTS, VALUES, max_size=4))
def test_a_record_comes_back_with_all_digits(record: dict) -> None:
    back = RecordFormat.decode(RecordFormat.encode(record))
    assert repr(back) == repr(record)  # repr tells 1 from 1.0 and 0.0 from -0.0


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_json_does_not_have_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="JSON"):
        RecordFormat.encode({"a": [value]})
