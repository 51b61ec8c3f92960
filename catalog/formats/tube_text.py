"""Tubes and needles as people write them: material, diameters, lengths, curvature."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from catalog.formats.robot_text import Closed, Number, Vector, at
from catalog.validation import unknown
from nodes.errors import BadInput
from nodes.mechanics.materials import MATERIALS, make_material
from nodes.mechanics.robots import Material, Needle, RoundTube, Tube

OTHER = "other"
"""A material that the table does not have; its three constants are given."""
_CONSTANTS = {
    "young_modulus_mpa": "Young's modulus",
    "poisson_ratio": "Poisson's ratio",
    "recoverable_strain": "recoverable strain",
}


class RoundTubeText(Closed):
    """What every tube's and needle's lines say."""

    material: str
    """nitinol, stainless steel, polycaprolactone, or other with all three constants"""
    young_modulus_mpa: Number | None = None
    """E, MPa, where the material's own is known better"""
    poisson_ratio: Number | None = None
    """nu, where the material's own is known better"""
    recoverable_strain: Number | None = None
    """largest strain from which it comes back, where the material's own is known better"""
    inner_diameter_mm: Number
    """mm; 0 for a wire"""
    outer_diameter_mm: Number
    """mm"""


class TubeText(RoundTubeText):
    """One tube of a concentric tube robot."""

    straight_length_mm: Number
    """mm, from its base"""
    curved_length_mm: Number
    """mm, up to its tip"""
    curvature_per_mm: Number
    """of the curved part when nothing bends it, 1/mm"""


class NeedleText(RoundTubeText):
    """One needle of a CRISP robot."""

    precurvature_per_mm: Vector = (0.0, 0.0, 0.0)
    """about its own x and y, and twist about z, when nothing bends it, 1/mm"""


def to_tube(text: TubeText, place: str) -> Tube:
    """Return the tube of a concentric tube robot; errors name its place in the file."""
    with at(place):
        return Tube(
            _to_material(text),
            text.inner_diameter_mm,
            text.outer_diameter_mm,
            text.straight_length_mm,
            text.curved_length_mm,
            text.curvature_per_mm,
        )


def to_needle(text: NeedleText, place: str) -> Needle:
    """Return the needle of a CRISP robot; errors name its place in the file."""
    with at(place):
        return Needle(
            _to_material(text),
            text.inner_diameter_mm,
            text.outer_diameter_mm,
            np.array(text.precurvature_per_mm),
        )


def tube_fields(tube: Tube) -> dict[str, Any]:
    """Return what a file says about a tube."""
    return _round_fields(tube) | {
        "straight_length_mm": tube.straight_length_mm,
        "curved_length_mm": tube.curved_length_mm,
        "curvature_per_mm": tube.curvature_per_mm,
    }


def needle_fields(needle: Needle) -> dict[str, Any]:
    """Return what a file says about a needle."""
    return _round_fields(needle) | {"precurvature_per_mm": needle.precurvature_per_mm.tolist()}


def material_notices(parts: Sequence[RoundTubeText]) -> list[str]:
    """Say which constants of which material are the literature's."""
    notices = []
    for material in dict.fromkeys(part.material.lower() for part in parts):
        same = [part for part in parts if part.material.lower() == material]
        taken = [
            meaning
            for key, meaning in _CONSTANTS.items()
            if any(getattr(part, key) is None for part in same)
        ]
        if taken:
            found = ", ".join(taken)
            notices.append(f"from the literature, not measured, for {material}: {found}")
    return notices


def _to_material(text: RoundTubeText) -> Material:
    name = text.material.lower()
    constants = {key: getattr(text, key) for key in _CONSTANTS}
    if name == OTHER and None not in constants.values():
        return Material(OTHER, **constants)
    if name == OTHER:
        raise BadInput(
            f"material = {OTHER} without {' and '.join(k for k in constants if not constants[k])}",
            "the constants of other materials are not known here",
            "write all three of them",
        )
    if name not in MATERIALS:
        raise unknown("material", name, [*MATERIALS, OTHER])
    return make_material(name, **constants)


def _round_fields(tube: RoundTube) -> dict[str, Any]:
    material = tube.material
    constants = {key: getattr(material, key) for key in _CONSTANTS}
    return {
        "material": material.name if material.name in MATERIALS else OTHER,
        **constants,
        "inner_diameter_mm": tube.inner_diameter_mm,
        "outer_diameter_mm": tube.outer_diameter_mm,
    }
