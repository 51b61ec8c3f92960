"""Versions of the packages that a stage computes with."""

import os
import sys
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

from catalog.memory import recall, remember


def package_versions(imports: Iterable[str], memory: Path) -> dict[str, str]:
    """Return distribution -> installed version for imported names, and Python's own.

    `memory` keeps which distribution brings which import; finding that out takes longer than all
    else in a run with nothing to do, and it changes only when something is installed.
    """
    providers = _providers(memory)
    names = {name for imported in imports for name in providers.get(imported, [imported])}
    return {"python": sys.version.split()[0]} | {name: _version(name) for name in sorted(names)}


def _version(distribution: str) -> str:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return "not installed"


def _providers(memory: Path) -> dict[str, list[str]]:
    folders = [path for path in sys.path if path.endswith(("site-packages", "dist-packages"))]
    stamp = [[path, os.stat(path).st_mtime_ns] for path in folders if os.path.isdir(path)]
    kept = recall(memory)
    if kept.get("stamp") == stamp and isinstance(kept.get("providers"), dict):
        return kept["providers"]
    found = metadata.packages_distributions()
    providers = {name: sorted(set(where)) for name, where in found.items()}
    remember(memory, {"stamp": stamp, "providers": providers})
    return providers
