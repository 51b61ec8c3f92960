"""Tables as CSV beside a Frictionless table schema, which keeps the types that CSV loses."""

import json
from collections.abc import Mapping
from io import StringIO
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


class TableFormat:
    """`table.csv` (numbers with all their digits) and `table.schema.json`."""

    @staticmethod
    def encode(value: "pd.DataFrame") -> dict[str, bytes]:
        """Return both files; the index is not kept: a table's rows name themselves in columns."""
        types = {str(name): str(dtype) for name, dtype in value.dtypes.items()}
        fields = [{"name": name, "type": _schema_type(t), "dtype": t} for name, t in types.items()]
        return {
            "table.csv": value.to_csv(index=False).encode("utf-8"),
            "table.schema.json": json.dumps({"fields": fields}, indent=1).encode("utf-8"),
        }

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> "pd.DataFrame":
        """Return the table of `encode` with the same columns, types and values."""
        import pandas as pd

        fields = json.loads(files["table.schema.json"])["fields"]
        return pd.read_csv(
            StringIO(files["table.csv"].decode("utf-8"), newline=""),
            dtype={field["name"]: field["dtype"] for field in fields},
            float_precision="round_trip",
            keep_default_na=False,
            na_values={f["name"]: [""] for f in fields if f["type"] != "string"},
        )


def _schema_type(dtype: str) -> str:
    """Return the Frictionless name of a pandas type."""
    for prefix, name in {"float": "number", "int": "integer", "uint": "integer"}.items():
        if dtype.lower().startswith(prefix):
            return name
    return "boolean" if dtype.startswith("bool") else "string"
