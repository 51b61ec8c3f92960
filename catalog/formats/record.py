"""Records: small nested values as JSON that a person can read."""

import json
from collections.abc import Mapping
from typing import Any


class RecordFormat:
    """`record.json`; floats keep all their digits."""

    @staticmethod
    def encode(value: dict[str, Any]) -> dict[str, bytes]:
        """Return the one file of a record; NaN and infinity are refused, as JSON has none."""
        text = json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False)
        return {"record.json": text.encode("utf-8")}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> dict[str, Any]:
        """Return the record of `encode`; of no files, the empty one."""
        return json.loads(files["record.json"]) if files else {}
