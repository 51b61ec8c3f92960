"""Robots as people write them: concentric tubes, and needles with snares, in one YAML file each.

robot: concentric_tubes
base:
  position_patient_mm: [0, 0, 0]    # where the tubes leave the base
  direction: [0, 0, 1]              # or rotation, or quaternion; see Orientation
tubes:                              # innermost first
  - material: nitinol               # see nodes/mechanics/materials.py
    young_modulus_mpa: 58000        # where it was measured; so may the two other constants
    inner_diameter_mm: 0.8
    outer_diameter_mm: 1.1
    straight_length_mm: 100
    curved_length_mm: 50
    curvature_per_mm: 0.025
translation_limits_mm: [[-100, 0]]  # of each tube; may be left out, as rotation_limits_deg

robot: crisp
needles:                            # the tool first
  - material: nitinol
    inner_diameter_mm: 0.97
    outer_diameter_mm: 1.27
    precurvature_per_mm: [0, 0, 0]  # may be left out
entry_points_patient_mm: [[0, 0, 0]]
snares:
  - needle: 1
    grasp_mm: 100
    measured_from: tip              # of the tool, or its entry; may be left out, as the two
    joint: relaxed                  # below
    cosine: 0
field_of_view_deg: 80
"""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from catalog.formats.robot_text import (
    Closed,
    Limit,
    Number,
    Orientation,
    OriginText,
    Vector,
    at,
    read_file,
    read_part,
    read_parts,
    robot_kind,
    to_origin,
    to_rotation,
    write_file,
)
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
from nodes.mechanics.robots import ConcentricTubeRobot, CrispSetup, Snare

__all__ = ["ConcentricTubeRobotFormat", "CrispSetupFormat", "robot_kind"]


class _BaseText(Orientation):
    position_patient_mm: Vector
    """where the tubes leave the base, patient LPS mm"""


class _ConcentricTubeRobotText(Closed):
    base: Any = None
    """position_patient_mm, and direction, rotation or quaternion"""
    tubes: list[Any]
    """one list item a tube, innermost first"""
    translation_limits_mm: list[tuple[Limit, Limit]] | None = None
    """least and largest translation of each tube, mm"""
    rotation_limits_deg: list[tuple[Limit, Limit]] | None = None
    """least and largest rotation of each tube, degrees"""
    rotation_limits_rad: list[tuple[Limit, Limit]] | None = None
    """the same in rad"""
    origin: OriginText | None = None
    """where it comes from"""


class _SnareText(Closed):
    needle: int
    """which needle's tip grasps, from 1; the tool is needle 0"""
    grasp_mm: Number
    """place on the tool, mm"""
    measured_from: Literal["tip", "entry"] | None = None
    """from where on the tool: tip (moves with the tool) or entry"""
    joint: Literal["rigid", "relaxed"] = Snare.joint
    """rigid or relaxed"""
    cosine: Number = Snare.cosine
    """of the angle between the tangents of tool and snare at a relaxed joint"""


class CrispSetupText(Closed):
    """A CRISP setup's lines."""

    needles: list[Any]
    """one list item a needle, the tool first"""
    entry_points_patient_mm: list[Vector]
    """where each needle enters, patient LPS mm"""
    snares: tuple[Any, ...] = ()
    """one list item a snare"""
    field_of_view_deg: Number
    """full angle of the camera's cone, degrees"""
    origin: OriginText | None = None
    """where it comes from"""


class ConcentricTubeRobotFormat:
    """`robot.yml` with `robot: concentric_tubes`."""

    @staticmethod
    def encode(value: ConcentricTubeRobot) -> dict[str, bytes]:
        """Return the one file; `decode` returns the same numbers, digit by digit."""
        base = value.patient_from_base
        fields: dict[str, Any] = {
            "base": {
                "position_patient_mm": base[:3, 3].tolist(),
                "rotation": base[:3, :3].tolist(),
            },
            "tubes": [tube_fields(tube) for tube in value.tubes],
        }
        if value.translation_limits_mm is not None:
            fields["translation_limits_mm"] = value.translation_limits_mm.tolist()
        if value.rotation_limits_rad is not None:
            fields["rotation_limits_rad"] = value.rotation_limits_rad.tolist()
        return write_file("robot.yml", "concentric_tubes", fields, value.origin)

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> ConcentricTubeRobot:
        """Read a robot.

        Raises
        ------
        BadInput for what is not as described above, and for a robot that cannot be.
        """
        text = read_file(files, "concentric_tubes", _ConcentricTubeRobotText)
        parts = read_parts(TubeText, text.tubes, "tubes")
        notices = material_notices(parts)
        if text.base is None:
            notices.append("the base stands in the patient's origin along +z, as the file has none")
        return ConcentricTubeRobot(
            tubes=tuple(to_tube(part, f"tubes[{index}]") for index, part in enumerate(parts)),
            patient_from_base=_to_pose(text.base),
            origin=to_origin(text.origin, "a robot handed in", notices),
            translation_limits_mm=_to_limits(text.translation_limits_mm),
            rotation_limits_rad=_to_rotation_limits(text),
        )


class CrispSetupFormat:
    """`setup.yml` with `robot: crisp`."""

    @staticmethod
    def encode(value: CrispSetup) -> dict[str, bytes]:
        """Return the one file; `decode` returns the same numbers, digit by digit."""
        return write_file("setup.yml", "crisp", setup_fields(value), value.origin)

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> CrispSetup:
        """Read a setup.

        Raises
        ------
        BadInput for what is not as described above, and for a setup that cannot be.
        """
        return to_setup(read_file(files, "crisp", CrispSetupText))


def setup_fields(setup: CrispSetup) -> dict[str, Any]:
    """Return what a file says about a setup."""
    return {
        "needles": [needle_fields(needle) for needle in setup.needles],
        "entry_points_patient_mm": setup.entry_points_patient_mm.tolist(),
        "snares": [vars(snare) for snare in setup.snares],
        "field_of_view_deg": setup.field_of_view_deg,
    }


def to_setup(text: CrispSetupText) -> CrispSetup:
    """Return the setup that a file tells."""
    parts = read_parts(NeedleText, text.needles, "needles")
    snares = read_parts(_SnareText, text.snares, "snares")
    notices = material_notices(parts) + _grasp_notices(snares)
    return CrispSetup(
        needles=tuple(to_needle(part, f"needles[{index}]") for index, part in enumerate(parts)),
        entry_points_patient_mm=np.array(text.entry_points_patient_mm, float).reshape(-1, 3),
        snares=tuple(_to_snare(snare, f"snares[{index}]") for index, snare in enumerate(snares)),
        field_of_view_deg=text.field_of_view_deg,
        origin=to_origin(text.origin, "a setup handed in", notices),
    )


def _to_snare(text: _SnareText, place: str) -> Snare:
    with at(place):
        measured_from = text.measured_from or Snare.measured_from
        return Snare(text.needle, text.grasp_mm, measured_from, text.joint, text.cosine)


def _to_pose(base: Any) -> np.ndarray:
    pose = np.eye(4)
    if base is not None:
        text = read_part(_BaseText, base, "base")
        pose[:3, :3] = to_rotation(text, "base")
        pose[:3, 3] = text.position_patient_mm
    return pose


def _to_limits(written: list[tuple[float, float]] | None) -> np.ndarray | None:
    return None if written is None else np.array(written, float).reshape(-1, 2)


def _to_rotation_limits(text: _ConcentricTubeRobotText) -> np.ndarray | None:
    if text.rotation_limits_deg is None:
        return _to_limits(text.rotation_limits_rad)
    if text.rotation_limits_rad is not None:
        raise BadInput(
            "rotation_limits_deg and rotation_limits_rad",
            "limits are written once, in degrees or in rad",
            "keep one of the two",
        )
    return np.radians(_to_limits(text.rotation_limits_deg))


def _grasp_notices(snares: list[_SnareText]) -> list[str]:
    if all(snare.measured_from for snare in snares):
        return []
    return [
        "where the file does not say it, grasps are measured from the tool's tip: the snare holds"
        " the tool's material"
    ]
