"""Poses and points as people mark them: text with numbers, 3D Slicer's markups, our own JSON.

Text files (.txt) hold one site each, in the RAS mm that 3D Slicer displays and Med-RAD
(github.com/UNC-Robotics/Med-RAD) ships: 4 x 4 numbers are a pose, 3 numbers a point. A file is a
site where it is called start... or target..., or begins with a number; other text is left alone.
Only the patient's side of a pose is converted, LPS = diag(-1, -1, 1, 1) RAS: the site's own axes
stay what they are, and the rotation stays one.

Markups (.mrk.json) say their coordinate system in the file; each of their control points is a
point, called by its label. Site names come from file names and labels, and pass on to all that is
made from them: none may be a patient's name.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from jaxtyping import Float

from catalog.formats.markups_file import (
    LPS_FROM_RAS,
    Site,
    read_markups,
    read_numbers,
    write_markups,
)
from nodes.errors import BadInput
from nodes.geometry.origin import Origin
from nodes.geometry.sites import Sites

_OWN = "sites.json"
_FRAME = "patient LPS, mm"
# Text with four decimals leaves the products of a rotation's columns off by about this.
ROTATION_TOLERANCE = 1e-3


class SitesFormat:
    """Any files in any nesting: .txt, .mrk.json, or our own sites.json; others are counted only."""

    @staticmethod
    def encode(value: Sites) -> dict[str, bytes]:
        """Write all digits to `sites.json`, and the same places for 3D Slicer to show."""
        fields = {
            "frame": _FRAME,
            "poses": [[name, pose.tolist()] for name, pose in _poses(value)],
            "points": [[name, point.tolist()] for name, point in _points(value)],
            "origin": asdict(value.origin),
        }
        return {_OWN: _to_json(fields), "sites.mrk.json": _to_json(write_markups(value))}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> Sites:
        """Read all sites; no file at all means that none are given.

        Raises
        ------
        BadInput where there are files but no site in them, for malformed numbers, for a pose that
        is no rotation and place, and for two sites of one name.
        """
        if not files:
            return Sites()
        if _OWN in files:
            return _read_own(files[_OWN])
        readers = {name: reader for name in sorted(files) if (reader := _reader(name, files[name]))}
        sites = [
            site
            for name, reader in readers.items()
            for site in reader(_stem(name), _text(_stem(name), files[name]))
        ]
        skipped = len(files) - len(readers)
        notices = (f"{skipped} files that hold no sites were left out",) if skipped else ()
        return _sites(sites, Origin("sites handed in", notices=notices), len(files))


def _poses(value: Sites) -> Iterator[Site]:
    return zip(value.pose_names, value.patient_from_site, strict=True)


def _points(value: Sites) -> Iterator[Site]:
    return zip(value.point_names, value.points_patient_mm, strict=True)


def _to_json(value: dict[str, Any]) -> bytes:
    return json.dumps(value, indent=1, ensure_ascii=True, allow_nan=False).encode()


def _stem(name: str) -> str:
    base = PurePosixPath(name).name
    return base[: -len(".mrk.json")] if base.lower().endswith(".mrk.json") else base[:-4]


def _reader(name: str, content: bytes) -> Callable[[str, str], list[Site]] | None:
    """Return how a file is read; None for a file that holds no site."""
    base = PurePosixPath(name).name.lower()
    if base.startswith("."):  # a computer's housekeeping (macOS: "._target.txt")
        return None
    if base.endswith(".mrk.json"):
        return read_markups
    first = (content.removeprefix(b"\xef\xbb\xbf").replace(b",", b" ").split() or [b""])[0]
    if base.endswith(".txt") and (base.startswith(("start", "target")) or _is_number(first)):
        return _read_text
    return None


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _text(name: str, content: bytes) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise BadInput(f"site {name}: no text", "a site file is text", "save it again") from None


def _read_text(name: str, text: str) -> list[Site]:
    rows = [line.replace(",", " ").split() for line in text.splitlines() if line.strip()]
    numbers = read_numbers(name, [word for row in rows for word in row])
    if [len(row) for row in rows] == [4, 4, 4, 4]:
        return [(name, LPS_FROM_RAS @ numbers.reshape(4, 4))]
    if len(numbers) == 3:
        return [(name, LPS_FROM_RAS[:3, :3] @ numbers)]
    raise BadInput(
        f"site {name}: {len(numbers)} numbers in {len(rows)} lines",
        "a pose has 4 lines of 4 numbers, a point 3 numbers (RAS, mm)",
        "write one site a file, and keep other text out of the input",
    )


def _read_own(content: bytes) -> Sites:
    try:
        fields = json.loads(content)
        if fields["frame"] != _FRAME:
            raise KeyError("frame")
        sites = [
            (str(name), np.array([read_numbers(name, row) for row in rows]).reshape(4, 4))
            for name, rows in fields["poses"]
        ]
        sites += [(str(name), read_numbers(name, row).reshape(3)) for name, row in fields["points"]]
        told = fields["origin"]
        origin = Origin(str(told["source"]), bool(told["simulated"]), tuple(told["notices"]))
    except BadInput:
        raise
    except (ValueError, KeyError, TypeError):
        raise BadInput(
            f"{_OWN} is not as expected",
            f'it has "frame": "{_FRAME}", "poses" as pairs of name and 4 x 4 numbers, "points" as'
            ' pairs of name and 3 numbers, and "origin"',
            "mend the file, or hand in text files or markups instead",
        ) from None
    return _sites(sites, origin)


def _sites(sites: list[Site], origin: Origin, files: int = 0) -> Sites:
    if files and not sites:
        raise BadInput(
            f"{files} files, no site in them",
            "sites are .txt files with 3 or 4 x 4 numbers (RAS, mm), or .mrk.json files",
            "name the folder that holds them, or leave the input out",
        )
    name, count = Counter(name for name, _ in sites).most_common(1)[0] if sites else ("", 0)
    if count > 1:
        raise BadInput(
            f"{count} sites are called {name}",
            "each site has a name of its own",
            "rename the files or the control points",
        )
    poses = [(name, _checked_pose(name, value)) for name, value in sites if value.ndim == 2]
    points = [(name, value) for name, value in sites if value.ndim == 1]
    return Sites(
        pose_names=tuple(name for name, _ in poses),
        patient_from_site=np.array([pose for _, pose in poses]).reshape(-1, 4, 4),
        point_names=tuple(name for name, _ in points),
        points_patient_mm=np.array([point for _, point in points]).reshape(-1, 3),
        origin=origin,
    )


def _checked_pose(name: str, pose: Float[np.ndarray, "4 4"]) -> Float[np.ndarray, "4 4"]:
    rotation = pose[:3, :3]
    off = float(abs(rotation.T @ rotation - np.eye(3)).max())
    mirrored = np.linalg.det(rotation) < 0
    if off > ROTATION_TOLERANCE or mirrored or (pose[3] != [0, 0, 0, 1]).any():
        found = "is mirrored" if mirrored else f"is off from a rotation by {off:.2g}"
        raise BadInput(
            f"site {name}: its 3 x 3 part {found}, its last line is {pose[3].tolist()}",
            f"a pose is a right-handed rotation (to {ROTATION_TOLERANCE:g}), a place in mm, and"
            " 0 0 0 1",
            "write the axes as columns of length 1 at right angles, and the place as last column",
        )
    return pose
