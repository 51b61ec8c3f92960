"""Origins and figures as the plain values that JSON holds, and back."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from nodes.geometry.origin import Origin
from nodes.mechanics.shapes import Figure

FRAME = "patient LPS, mm"
COMPUTED = "computed by a model, not measured"
"""Stands in all files of planning, that other programs open without our page."""


def to_json(fields: Mapping[str, Any]) -> bytes:
    """Return readable JSON in ASCII, floats with all their digits; nan and infinity are refused."""
    return json.dumps(fields, indent=1, allow_nan=False).encode("ascii")


def plain_figures(figures: Iterable[Figure]) -> list[dict[str, Any]]:
    """Return figures as JSON holds them."""
    return [asdict(figure) for figure in figures]


def read_figures(told: Iterable[Mapping[str, Any]]) -> tuple[Figure, ...]:
    """Return the figures of `plain_figures`."""
    return tuple(Figure(**figure) for figure in told)


def read_origin(told: Mapping[str, Any]) -> Origin:
    """Return the origin that `asdict` made plain."""
    return Origin(told["source"], told["simulated"], tuple(told["notices"]))


def tell_origin(origin: Origin) -> list[str]:
    """Return what the files of an artefact say for other programs' users."""
    simulated = ["simulated"] if origin.simulated else []
    return [f"{FRAME}; {COMPUTED}", *simulated, *origin.notices]
