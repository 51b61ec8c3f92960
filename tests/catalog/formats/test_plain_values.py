"""Origins and figures come back from JSON, and its bytes are plain."""

import json
from dataclasses import asdict

import pytest
from hypothesis import given
from hypothesis import strategies as st

from catalog.formats.plain_values import (
    COMPUTED,
    plain_figures,
    read_figures,
    read_origin,
    tell_origin,
    to_json,
)
from nodes.geometry.origin import Origin
from nodes.mechanics.shapes import Figure
from tests.catalog.formats.hostile import ORIGINS, TEXTS


@given(ORIGINS, st.lists(st.builds(Figure, TEXTS, st.floats(-1e9, 1e9), TEXTS, TEXTS)))
def test_origins_and_figures_come_back(origin, figures) -> None:
    content = to_json({"origin": asdict(origin), "figures": plain_figures(figures)})
    told = json.loads(content)
    assert content.isascii()
    assert read_origin(told["origin"]) == origin
    assert read_figures(told["figures"]) == tuple(figures)


def test_what_json_cannot_hold_is_refused() -> None:
    with pytest.raises(ValueError, match="JSON compliant"):
        to_json({"a": float("nan")})


def test_files_tell_that_they_are_computed_and_what_is_simulated() -> None:
    told = tell_origin(Origin("a phantom", True, ("a notice",)))
    assert COMPUTED in told[0] and told[1:] == ["simulated", "a notice"]
