"""Tables come back with columns, types and values as they were, and the csv module reads them."""

import csv
import json
from io import StringIO

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.formats.table import TableFormat
from tests.catalog.formats.hostile import NAMES, TEXTS

# What a reader of CSV takes for a missing value, a number or a truth value by mistake.
WORDS = TEXTS | st.sampled_from(["NA", "nan", "None", "null", "", "1", "01", "1e5", "True", " x "])
COLUMNS = {
    "str": WORDS,
    "bool": st.booleans(),
    "int64": st.integers(-(2**63), 2**63 - 1),
    "uint8": st.integers(0, 255),
    "float64": st.floats(),
    "float32": st.floats(width=32),
    "Int64": st.integers(-9, 9) | st.none(),
}


@st.composite
def tables(draw: st.DrawFn) -> pd.DataFrame:
    names = draw(st.lists(NAMES, min_size=1, max_size=4, unique=True))
    rows = draw(st.integers(0, 4))
    columns = {}
    for name in names:
        dtype = draw(st.sampled_from(list(COLUMNS)))
        values = draw(st.lists(COLUMNS[dtype], min_size=rows, max_size=rows))
        columns[name] = pd.Series(values, dtype=dtype)
    return pd.DataFrame(columns)


def check_round_trip(table: pd.DataFrame) -> None:
    back = TableFormat.decode(TableFormat.encode(table))
    pd.testing.assert_frame_equal(back, table, check_exact=True, check_index_type=False)


@settings(max_examples=120, deadline=None)
@given(tables())
def test_columns_types_and_values_come_back(table: pd.DataFrame) -> None:
    check_round_trip(table)


@pytest.mark.parametrize("dtype", COLUMNS)
def test_an_empty_table_keeps_its_types(dtype: str) -> None:
    check_round_trip(
        pd.DataFrame({"a": pd.Series([], dtype=dtype), "b": pd.Series([], dtype="str")})
    )


def test_a_single_column_with_gaps_keeps_all_rows() -> None:
    check_round_trip(pd.DataFrame({"a": [np.nan, 1.0, np.nan]}))
    check_round_trip(pd.DataFrame({"a": ["", "x", ""]}))


@pytest.mark.parametrize(
    "table",
    [
        pd.DataFrame({"a": ["x", None]}),
        pd.DataFrame([[1, 2]], columns=["a", "a"]),
        pd.DataFrame([[1, 2]], columns=[0, 1]),
        pd.DataFrame({"a": pd.to_datetime(["2000-01-01"])}),
        pd.DataFrame({"a": [[1], {}]}),
        pd.DataFrame(),
        pd.DataFrame({"a": [1 + 2j]}),
    ],
    ids=[
        "missing text",
        "columns of one name",
        "numbered columns",
        "dates",
        "objects",
        "no columns",
        "complex",
    ],
)
def test_what_the_format_cannot_keep_is_refused_and_never_altered(table: pd.DataFrame) -> None:
    with pytest.raises(ValueError, match="a table"):
        TableFormat.encode(table)


def test_the_csv_module_reads_what_was_written() -> None:
    table = pd.DataFrame(
        {"na,me": ['a "quoted", word', "two\nlines\r", "é"], "n": [0.1, -1e300, 2.0]}
    )
    text = TableFormat.encode(table)["table.csv"].decode()
    header, *rows = csv.reader(StringIO(text, newline=""))
    assert header == ["na,me", "n"]
    assert [row[0] for row in rows] == list(table["na,me"])
    assert [float(row[1]) for row in rows] == list(table["n"])


def test_the_schema_names_types_of_the_frictionless_standard() -> None:
    table = pd.DataFrame({"a": [1], "b": [1.5], "c": [True], "d": ["x"]})
    fields = json.loads(TableFormat.encode(table)["table.schema.json"])["fields"]
    assert [f["type"] for f in fields] == ["integer", "number", "boolean", "string"]
