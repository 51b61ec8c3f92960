"""Tables as CSV beside a Frictionless table schema, which keeps the types that CSV loses."""

import json
from collections.abc import Mapping
from io import StringIO
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

_KEPT = ("float", "int", "uint", "bool", "str")


class TableFormat:
    """`table.csv` (numbers with all their digits) and `table.schema.json`."""

    @staticmethod
    def encode(value: "pd.DataFrame") -> dict[str, bytes]:
        """Return both files; the index is not kept: a table's rows name themselves in columns.

        Raises
        ------
        ValueError : for a table that CSV would alter.
        """
        _check(value)
        types = {name: str(dtype) for name, dtype in value.dtypes.items()}
        fields = [{"name": name, "type": _schema_type(t), "dtype": t} for name, t in types.items()]
        # RFC 4180 ends lines with both characters; only so is text with one of them quoted.
        return {
            "table.csv": value.to_csv(index=False, lineterminator="\r\n").encode("utf-8"),
            "table.schema.json": json.dumps({"fields": fields}, indent=1).encode("utf-8"),
        }

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> "pd.DataFrame":
        """Return the table of `encode` with the same columns, types and values."""
        import pandas as pd

        fields = json.loads(files["table.schema.json"])["fields"]
        return pd.read_csv(
            StringIO(files["table.csv"].decode("utf-8"), newline=""),
            names=[field["name"] for field in fields],
            header=0,
            index_col=False,
            skip_blank_lines=False,
            dtype={field["name"]: field["dtype"] for field in fields},
            keep_default_na=False,
            na_values={f["name"]: [""] for f in fields if f["type"] != "string"},
        )


def _check(table: "pd.DataFrame") -> None:
    """Refuse what would come back as something else."""
    names = list(table.columns)
    if not names or len(set(names)) < len(names) or not all(isinstance(n, str) for n in names):
        raise ValueError(f"a table needs columns with names of their own, not {names}")
    for name, dtype in table.dtypes.items():
        if not str(dtype).lower().startswith(_KEPT):
            raise ValueError(f"a table holds numbers, truth values and text: {name} is {dtype}")
        if _schema_type(str(dtype)) == "string" and table[name].isna().any():
            raise ValueError(
                f"a table's text must not be missing: write some word for it in {name}"
            )


def _schema_type(dtype: str) -> str:
    """Return the Frictionless name of a pandas type."""
    for prefix, name in {"float": "number", "int": "integer", "uint": "integer"}.items():
        if dtype.lower().startswith(prefix):
            return name
    return "boolean" if dtype.startswith("bool") else "string"
