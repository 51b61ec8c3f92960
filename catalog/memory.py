"""Small JSON files that only save time: losing one costs no more than finding things out again."""

import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any


def recall(path: Path) -> dict[str, Any]:
    """Return what was remembered; nothing where the file is missing or damaged."""
    try:
        known = json.loads(path.read_text())
    except (OSError, ValueError, RecursionError):
        return {}
    return known if isinstance(known, dict) else {}


def remember(path: Path, known: dict[str, Any]) -> None:
    """Remember by one rename; a full disk or a lost race is no error here."""
    scratch = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch.write_text(json.dumps(known))
        os.replace(scratch, path)
    except OSError:
        with suppress(OSError):
            scratch.unlink()
