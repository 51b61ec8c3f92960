"""Names of series tell no identifier, also where a person wrote one."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodes.imaging.series_key import name_series, series_key
from tests.nodes.imaging.made_planes import settings_of

UIDS = st.from_regex(r"[0-2](\.(0|[1-9][0-9]{0,12})){3,9}", fullmatch=True)


@given(UIDS)
def test_a_uid_that_is_written_is_kept_as_its_key_only(uid):
    parameters = settings_of(series=uid)
    assert parameters.series == series_key(uid)
    assert uid not in repr(parameters) and uid not in parameters.model_dump_json()
    assert settings_of(series=parameters.series) == parameters


@given(UIDS, UIDS)
def test_keys_tell_series_apart(one, other):
    assert (series_key(one) == series_key(other)) == (one == other)


@pytest.mark.parametrize(("written", "kept"), [("", ""), (3, "3"), ("12", "12"), (" 2 ", "2")])
def test_numbers_stay_as_written(written, kept):
    assert name_series(written) == kept


@pytest.mark.parametrize("written", ["09bc8aea-ff9c", "0", "-1", "1.2", "SIUID", "s12", "123456"])
def test_what_is_no_number_and_no_key_is_hashed_and_never_quoted(written):
    assert name_series(written) == series_key(written)
