"""A tube's lines say its material by name, and replace what was measured."""

import pytest

from catalog.formats.tube_text import (
    NeedleText,
    TubeText,
    material_notices,
    needle_fields,
    to_needle,
    to_tube,
    tube_fields,
)
from nodes.errors import BadInput
from nodes.mechanics.materials import STAINLESS_STEEL
from nodes.mechanics.robots import Material, Needle, Tube

RING = {"inner_diameter_mm": 1, "outer_diameter_mm": 2}
CONSTANTS = {"young_modulus_mpa": 7, "poisson_ratio": 0.2, "recoverable_strain": 0.5}
PARTS = {"straight_length_mm": 3, "curved_length_mm": 4, "curvature_per_mm": 0.1}


def test_lines_become_the_fields_of_a_tube_and_back():
    written = {"material": "other"} | CONSTANTS | RING | PARTS
    tube = to_tube(TubeText(**written), "here")
    assert tube == Tube(Material("other", 7.0, 0.2, 0.5), 1.0, 2.0, 3.0, 4.0, 0.1)
    assert tube_fields(tube) == written


def test_lines_become_the_fields_of_a_needle_and_back():
    written = {"material": "stainless steel"} | CONSTANTS | RING
    written["precurvature_per_mm"] = [0.1, 0.0, -0.1]
    needle = to_needle(NeedleText(**written), "here")
    assert isinstance(needle, Needle)
    assert needle_fields(needle) == written


def test_names_that_the_table_does_not_have_are_not_written():
    """They could be anybody's."""
    tube = Tube(Material("Jane's", 7.0, 0.2, 0.5), 1.0, 2.0, 3.0, 4.0, 0.1)
    assert tube_fields(tube)["material"] == "other"


def test_capitals_do_not_matter():
    text = NeedleText(material="Stainless Steel", **RING)
    assert to_needle(text, "here").material == STAINLESS_STEEL


def test_only_what_the_file_does_not_say_is_told_to_be_the_literatures():
    known = NeedleText(material="nitinol", **CONSTANTS, **RING)
    partly = NeedleText(material="Nitinol", poisson_ratio=0.3, **RING)
    assert material_notices([known]) == []
    assert material_notices([known, partly]) == [
        "from the literature, not measured, for nitinol: Young's modulus, recoverable strain"
    ]


def test_errors_name_the_place():
    wrong = TubeText(material="nitinol", **RING, **(PARTS | {"curved_length_mm": -4}))
    with pytest.raises(BadInput, match=r"^tubes\[3\]: curved_length_mm = -4 mm"):
        to_tube(wrong, "tubes[3]")
