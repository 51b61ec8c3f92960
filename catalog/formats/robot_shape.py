"""Shapes of robots: the backbone as CSV and VTP (ParaView, 3D Slicer), the rest as JSON."""

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from io import StringIO
from typing import Any

import numpy as np

from catalog.formats.vtp_file import write_curves
from nodes.geometry.origin import Origin
from nodes.mechanics.shapes import Figure, RobotShape, Rod

_COLUMNS = (
    "rod", "name", "arc_length_mm", "x_mm", "y_mm", "z_mm", "tangent_x", "tangent_y", "tangent_z",
    "outer_radius_mm",
)  # fmt: skip
_FRAME = "patient LPS, mm"
COMPUTED = "computed by a model of the robot's mechanics, not measured"
"""Stands in the files of every shape, that other programs open without our page."""


class RobotShapeFormat:
    """`backbone.csv`, `backbone.vtp` (curves with radius and tangent) and `shape.json`.

    Numbers keep all their digits; the CSV and the JSON together hold all of the artefact.
    """

    @staticmethod
    def encode(value: RobotShape) -> dict[str, bytes]:
        """Return the three files."""
        notes = [f"{_FRAME}; {COMPUTED}", f"status: {value.status}", *value.origin.notices]
        notes += ["simulated"] if value.origin.simulated else []
        return {
            "backbone.csv": _write_csv(value.rods),
            "backbone.vtp": write_curves(
                [rod.points_patient_mm for rod in value.rods], _point_data(value.rods), notes
            ),
            "shape.json": _write_json(value),
        }

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> RobotShape:
        """Return the shape of `encode`, equal in every field."""
        told = json.loads(files["shape.json"])
        rods = _read_csv(files["backbone.csv"])
        origin = told["origin"]
        tip = np.array(told["patient_from_tip"], float)
        return RobotShape(
            kind=told["kind"],
            status=told["status"],
            reason=told["reason"],
            given=tuple(Figure(**figure) for figure in told["given"]),
            rods=rods,
            patient_from_tip=tip.reshape(len(tip), len(tip)),
            joints_patient_mm=np.array(told["joints_patient_mm"], float).reshape(-1, 3),
            loads=np.array(told["loads"], float).reshape(-1, 6),
            figures=tuple(Figure(**figure) for figure in told["figures"]),
            origin=Origin(origin["source"], origin["simulated"], tuple(origin["notices"])),
        )


def _point_data(rods: Sequence[Rod]) -> dict[str, np.ndarray]:
    """Return what stands at every point of the curves, by name."""
    if not rods:
        return {}
    return {
        "rod": np.concatenate([np.full(len(r.arc_lengths_mm), n) for n, r in enumerate(rods)]),
        "arc_length_mm": np.concatenate([rod.arc_lengths_mm for rod in rods]),
        "tangent": np.concatenate([rod.tangents for rod in rods]),
        "outer_radius_mm": np.concatenate(
            [np.full(len(rod.arc_lengths_mm), rod.outer_radius_mm) for rod in rods]
        ),
    }


def _write_csv(rods: Sequence[Rod]) -> bytes:
    text = StringIO(newline="")
    rows = csv.writer(text)
    rows.writerow(_COLUMNS)
    for number, rod in enumerate(rods):
        numbers = np.column_stack([rod.arc_lengths_mm, rod.points_patient_mm, rod.tangents])
        for row in numbers.tolist():
            rows.writerow([number, rod.name, *map(repr, row), repr(float(rod.outer_radius_mm))])
    return text.getvalue().encode("utf-8")


def _read_csv(content: bytes) -> tuple[Rod, ...]:
    rows = list(csv.reader(StringIO(content.decode("utf-8"), newline="")))[1:]
    rods = []
    for number in sorted({int(row[0]) for row in rows}):
        own = [row for row in rows if int(row[0]) == number]
        numbers = np.array([row[2:] for row in own], float)
        rods.append(
            Rod(own[0][1], numbers[:, 0], numbers[:, 1:4], numbers[:, 4:7], float(numbers[0, 7]))
        )
    return tuple(rods)


def _write_json(value: RobotShape) -> bytes:
    fields: dict[str, Any] = {
        "frame": _FRAME,
        "note": COMPUTED,
        "kind": value.kind,
        "status": value.status,
        "reason": value.reason,
        "given": [asdict(figure) for figure in value.given],
        "patient_from_tip": value.patient_from_tip.tolist(),
        "joints_patient_mm": value.joints_patient_mm.tolist(),
        "loads": value.loads.tolist(),
        "figures": [asdict(figure) for figure in value.figures],
        "origin": asdict(value.origin),
    }
    return json.dumps(fields, indent=1, allow_nan=False).encode("utf-8")
