"""CRISP setups in a patient, with where their robots start: a folder of one YAML file each.

robot: crisp                        # then as every CRISP setup is written; see robot.py
needles: [...]
entry_points_patient_mm: [...]
snares: [...]
field_of_view_deg: 80
start:                              # no loads
  lengths_mm: [120, 90]             # how far each needle is inside, the tool first
  orientations:
    - direction: [0.2, 0, -1]
    - direction: [1, 0, 0]
axes: [[0, 0, -1], [1, 0, 0]]       # about which needles tilt; may be left out, as all below
largest_tilts_deg: [60, 45]
shortest_mm: [20, 10]               # limits of the lengths beyond the entry points
longest_mm: [200, 150]
entries: [3, 7]                     # numbers in the table of entry points

A setup is called by its file's name, which passes on to all that is made from it: none may be a
patient's name.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from jaxtyping import Float

from catalog.formats.configuration import CrispText, configuration_fields, to_configuration
from catalog.formats.plain_values import read_origin, to_json
from catalog.formats.robot import CrispSetupText, setup_fields, to_setup
from catalog.formats.robot_text import Number, Vector, at, read_file, read_part, write_file
from nodes.errors import BadInput
from nodes.geometry.origin import Origin
from nodes.mechanics.robots import CrispConfiguration, CrispSetup
from nodes.planning.artefacts import PlacedSetup, PlacedSetups

_LIST = "setups.json"
_SUFFIXES = (".yml", ".yaml")
# What is assumed where a file does not limit the motion; a person at the patient knows better.
TILT_DEG = 60.0
SHORTEST_MM = 10.0  # of a snare, and of the tool before its first grasp
LONGEST_MM = 300.0
Lengths = Float[np.ndarray, "needle"]


class _PlacedText(CrispSetupText):
    start: Any
    """lengths_mm and orientations"""
    axes: list[Vector] | None = None
    """one direction a needle about which it tilts, patient LPS"""
    largest_tilts_deg: list[Number] | None = None
    """how far each needle may turn from its axis, degrees"""
    largest_tilts_rad: list[Number] | None = None
    """the same in rad"""
    shortest_mm: list[Number] | None = None
    """least length of each needle beyond its entry point, mm"""
    longest_mm: list[Number] | None = None
    """largest length of each needle beyond its entry point, mm"""
    entries: tuple[int, ...] = ()
    """numbers of the entry points in the table of entries, the tool's first"""


class PlacedSetupsFormat:
    """`setup_1.yml` and so on, and `setups.json`, which keeps names, order and origin."""

    @staticmethod
    def encode(value: PlacedSetups) -> dict[str, bytes]:
        """Return all files; `decode` returns the same numbers, digit by digit."""
        files, listed = {}, []
        for number, placed in enumerate(value.setups, start=1):
            name = f"setup_{number}.yml"
            files |= write_file(name, "crisp", _fields(placed), placed.setup.origin)
            listed.append({"file": name, "name": placed.name})
        told = {"setups": listed, "origin": asdict(value.origin)}
        return {**files, _LIST: to_json(told)}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> PlacedSetups:
        """Read all setups; no file at all means that none are given.

        Raises
        ------
        BadInput where there are files but no setup in them, and for what is not as described above.
        """
        if not files:
            return PlacedSetups((), Origin("no setups given"))
        if _LIST in files:
            return _read_own(files)
        names = [name for name in sorted(files) if _is_setup(name)]
        if not names:
            raise BadInput(
                f"{len(files)} files, no setup in them",
                "a setup in a patient is one YAML file (.yml)",
                "name the folder that holds them, or leave the input out",
            )
        setups = tuple(_read(PurePosixPath(name).stem, files[name]) for name in names)
        _refuse_equal_names(setups)
        skipped = len(files) - len(names)
        notices = [f"{skipped} files that hold no setup were left out"] if skipped else []
        notices += [notice for placed in setups for notice in placed.setup.origin.notices]
        return PlacedSetups(setups, Origin("setups handed in").with_notice(*notices))


def _is_setup(name: str) -> bool:
    """A name that begins with a dot belongs to a computer's housekeeping (macOS: "._1.yml")."""
    path = PurePosixPath(name)
    return path.suffix.lower() in _SUFFIXES and not path.name.startswith(".")


def _read_own(files: Mapping[str, bytes]) -> PlacedSetups:
    told = json.loads(files[_LIST])
    setups = tuple(_read(each["name"], files[each["file"]]) for each in told["setups"])
    return PlacedSetups(setups, read_origin(told["origin"]))


def _fields(placed: PlacedSetup) -> dict[str, Any]:
    return setup_fields(placed.setup) | {
        "start": configuration_fields(placed.start),
        "axes": placed.axes.tolist(),
        "largest_tilts_rad": placed.largest_tilts_rad.tolist(),
        "shortest_mm": placed.shortest_mm.tolist(),
        "longest_mm": placed.longest_mm.tolist(),
        "entries": list(placed.entries),
    }


def _read(name: str, content: bytes) -> PlacedSetup:
    with at(f"setup {name}"):
        text = read_file({"": content}, "crisp", _PlacedText)
        setup = to_setup(text)
        start_text = read_part(CrispText, text.start, "start")
        with at("start"):
            start = to_configuration(start_text)
        return _place(name, text, setup, start)


def _place(
    name: str, text: _PlacedText, setup: CrispSetup, start: CrispConfiguration
) -> PlacedSetup:
    """Return the setup with its limits; where none are written, those assumed, and a notice."""
    lengths = start.lengths_mm
    _count("start.lengths_mm", lengths, setup)
    axes = start.patient_from_entry[:, :, 2] if text.axes is None else _units(text.axes)
    tilts = np.full(len(lengths), np.radians(TILT_DEG)) if _has_no_tilts(text) else _tilts(text)
    shortest = np.minimum(_shortest(setup), lengths)
    if text.shortest_mm is not None:
        shortest = np.array(text.shortest_mm, float)
    longest = np.maximum(LONGEST_MM, lengths)
    if text.longest_mm is not None:
        longest = np.array(text.longest_mm, float)
    limits = {"axes": axes, "largest_tilts": tilts, "shortest_mm": shortest, "longest_mm": longest}
    for field, values in limits.items():
        _count(field, values, setup)
    _check_limits(tilts, shortest, longest)
    notices = [f"{name}: assumed, as the file does not say it: {what}"
               for what in _assumed(text, shortest, longest)]  # fmt: skip
    if notices:
        setup = replace(setup, origin=setup.origin.with_notice(*notices))
    return PlacedSetup(name, setup, start, axes, tilts, shortest, longest, text.entries)


def _has_no_tilts(text: _PlacedText) -> bool:
    return text.largest_tilts_deg is None and text.largest_tilts_rad is None


def _assumed(text: _PlacedText, shortest: Lengths, longest: Lengths) -> list[str]:
    """Return what the file leaves open, as sentences."""
    said = {
        "needles tilt about their direction at the start": text.axes is None,
        f"needles tilt by at most {TILT_DEG:g} degrees": _has_no_tilts(text),
        f"needles stay at least {shortest.min():g} mm inside": text.shortest_mm is None,
        f"needles reach at most {longest.max():g} mm inside": text.longest_mm is None,
    }
    return [sentence for sentence, is_open in said.items() if is_open]


def _shortest(setup: CrispSetup) -> Lengths:
    """Return the least lengths that are assumed; the tool's leaves its grasps inside."""
    grasp = max((snare.grasp_mm for snare in setup.snares), default=0.0)
    shortest = np.full(len(setup.needles), SHORTEST_MM)
    shortest[0] += grasp
    return shortest


def _tilts(text: _PlacedText) -> Float[np.ndarray, "needle"]:
    if text.largest_tilts_deg is not None and text.largest_tilts_rad is not None:
        raise BadInput(
            "largest_tilts_deg and largest_tilts_rad",
            "limits are written once, in degrees or in rad",
            "keep one of the two",
        )
    if text.largest_tilts_deg is not None:
        return np.radians(np.array(text.largest_tilts_deg, float))
    return np.array(text.largest_tilts_rad, float)


def _units(axes: Sequence[Sequence[float]]) -> Float[np.ndarray, "needle 3"]:
    """Return directions of any length as unit vectors; unit vectors digit by digit."""
    vectors = np.array(axes, float).reshape(-1, 3)
    sizes = np.linalg.norm(vectors, axis=1, keepdims=True)
    if not sizes.all():
        raise BadInput(f"axes = {vectors.tolist()}", "a direction is not zero", "write another")
    return np.where(abs(sizes - 1) < 1e-12, vectors, vectors / sizes)


def _count(field: str, values: np.ndarray, setup: CrispSetup) -> None:
    if len(values) != len(setup.needles):
        raise BadInput(
            f"{len(values)} {field} and {len(setup.needles)} needles",
            "each needle has one of each",
            "add what is missing",
        )


def _check_limits(
    tilts_rad: Float[np.ndarray, "needle"], shortest: Lengths, longest: Lengths
) -> None:
    for needle, (tilt, least, most) in enumerate(
        zip(np.degrees(tilts_rad), shortest, longest, strict=True)
    ):
        if not 0 <= tilt <= 180:
            raise BadInput(
                f"needle {needle} tilts by at most {tilt:g} degrees",
                "a tilt is between 0 and 180 degrees",
                "correct largest_tilts_deg",
            )
        if not 0 < least <= most:
            raise BadInput(
                f"needle {needle} is between {least:g} and {most:g} mm long",
                "its least length is above 0 and not above its largest",
                "correct shortest_mm or longest_mm",
            )


def _refuse_equal_names(setups: Iterable[PlacedSetup]) -> None:
    names = [placed.name for placed in setups]
    twice = [name for place, name in enumerate(names) if name in names[:place]]
    if twice:
        raise BadInput(
            f"two setups are called {twice[0]}", "each has a name of its own", "rename a file"
        )
