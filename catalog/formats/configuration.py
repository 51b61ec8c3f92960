"""Joint values as people write them, in one YAML file.

robot: concentric_tubes
rotations_deg: [63.3, -102.8]       # of each tube where it is clamped, innermost first
translations_mm: [-1, 0]            # of each tube's base, not in front of the entry plane

robot: crisp
lengths_mm: [190, 140]              # how far each needle is inside, the tool first
orientations:                       # of each needle where it enters; see Orientation
  - direction: [0.2, 0, -1]
    roll_deg: 30
  - quaternion: [1, 0, 0, 0]
loads:                              # what pulls on the tool; may be left out
  - arc_length_mm: 185              # from the tool's entry point
    force_n: [0, 0, -0.2]           # in patient LPS
    moment_n_mm: [0, 0, 0]          # in patient LPS; may be left out
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from catalog.formats.robot_text import (
    Closed,
    Number,
    Orientation,
    Vector,
    at,
    read_file,
    read_part,
    to_rotation,
    write_file,
)
from nodes.errors import BadInput
from nodes.mechanics.robots import (
    ConcentricTubeConfiguration,
    CrispConfiguration,
    PointLoad,
)


class _ConcentricTubeText(Closed):
    rotations_deg: list[Number] | None = None
    """of each tube where it is clamped, innermost first, degrees"""
    rotations_rad: list[Number] | None = None
    """the same in rad"""
    translations_mm: list[Number]
    """place of each tube's base along the base's z, mm; not above 0"""


class _LoadText(Closed):
    arc_length_mm: Number
    """from the tool's entry point, mm"""
    force_n: Vector
    """in patient LPS, N"""
    moment_n_mm: Vector = (0.0, 0.0, 0.0)
    """in patient LPS, N mm"""


class CrispText(Closed):
    """A CRISP robot's joint values and loads."""

    lengths_mm: list[Number]
    """how far each needle reaches beyond its entry point, the tool first, mm"""
    orientations: list[Any]
    """one list item a needle: direction, rotation or quaternion"""
    loads: tuple[Any, ...] = ()
    """one list item a load"""


class ConcentricTubeConfigurationFormat:
    """`configuration.yml` with `robot: concentric_tubes`."""

    @staticmethod
    def encode(value: ConcentricTubeConfiguration) -> dict[str, bytes]:
        """Return the one file; `decode` returns the same numbers, digit by digit."""
        fields = {
            "rotations_rad": value.rotations_rad.tolist(),
            "translations_mm": value.translations_mm.tolist(),
        }
        return write_file("configuration.yml", "concentric_tubes", fields)

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> ConcentricTubeConfiguration:
        """Read joint values; whether a robot can take them is not looked at here.

        Raises
        ------
        BadInput for what is not as described above.
        """
        text = read_file(files, "concentric_tubes", _ConcentricTubeText)
        rotations = _to_rotations(text)
        if len(rotations) != len(text.translations_mm):
            raise BadInput(
                f"{len(rotations)} rotations and {len(text.translations_mm)} translations",
                "each tube has one of each",
                "add what is missing",
            )
        return ConcentricTubeConfiguration(rotations, np.array(text.translations_mm, float))


def _to_rotations(text: _ConcentricTubeText) -> np.ndarray:
    if (text.rotations_deg is None) == (text.rotations_rad is None):
        raise BadInput(
            "rotations_deg and rotations_rad"
            if text.rotations_deg is not None
            else "no rotations_deg",
            "rotations are written once, in degrees or in rad",
            "keep one line `rotations_deg: [...]`",
        )
    if text.rotations_deg is not None:
        return np.radians(np.array(text.rotations_deg, float))
    return np.array(text.rotations_rad, float)


class CrispConfigurationFormat:
    """`configuration.yml` with `robot: crisp`."""

    @staticmethod
    def encode(value: CrispConfiguration) -> dict[str, bytes]:
        """Return the one file; `decode` returns the same numbers, digit by digit."""
        return write_file("configuration.yml", "crisp", configuration_fields(value))

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> CrispConfiguration:
        """Read joint values; whether a robot can take them is not looked at here.

        Raises
        ------
        BadInput for what is not as described above.
        """
        return to_configuration(read_file(files, "crisp", CrispText))


def configuration_fields(value: CrispConfiguration) -> dict[str, Any]:
    """Return what a file says about joint values and loads."""
    return {
        "lengths_mm": value.lengths_mm.tolist(),
        "orientations": [{"rotation": turn.tolist()} for turn in value.patient_from_entry],
        "loads": [
            {
                "arc_length_mm": load.arc_length_mm,
                "force_n": load.force_n.tolist(),
                "moment_n_mm": load.moment_n_mm.tolist(),
            }
            for load in value.loads
        ],
    }


def to_configuration(text: CrispText) -> CrispConfiguration:
    """Return the joint values that a file tells."""
    if len(text.lengths_mm) != len(text.orientations):
        raise BadInput(
            f"{len(text.lengths_mm)} lengths and {len(text.orientations)} orientations",
            "each needle has one of each",
            "add what is missing",
        )
    turns = [
        _to_turn(part, f"orientations[{index}]") for index, part in enumerate(text.orientations)
    ]
    return CrispConfiguration(
        patient_from_entry=np.array(turns).reshape(-1, 3, 3),
        lengths_mm=np.array(text.lengths_mm, float),
        loads=tuple(_to_load(part, f"loads[{index}]") for index, part in enumerate(text.loads)),
    )


def _to_turn(part: Any, place: str) -> np.ndarray:
    return to_rotation(read_part(Orientation, part, place), place)


def _to_load(part: Any, place: str) -> PointLoad:
    text = read_part(_LoadText, part, place)
    with at(place):
        return PointLoad(text.arc_length_mm, np.array(text.force_n), np.array(text.moment_n_mm))
