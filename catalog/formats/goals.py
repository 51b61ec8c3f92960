"""Goals on a cavity's surface: all of them as JSON, and their points for 3D Slicer."""

import json
from collections.abc import Mapping
from dataclasses import asdict

import numpy as np

from catalog.formats.markups_file import write_markups
from catalog.formats.plain_values import FRAME, read_origin, to_json
from nodes.geometry.sites import Sites
from nodes.planning.artefacts import Goals


class GoalsFormat:
    """`goals.json`, which holds all, and `goals.mrk.json`."""

    @staticmethod
    def encode(value: Goals) -> dict[str, bytes]:
        """Return both files."""
        points = Sites(point_names=value.names, points_patient_mm=value.points_patient_mm)
        fields = {
            "frame": FRAME,
            "names": value.names,
            "cells": value.cells.tolist(),
            "goals": value.goals.tolist(),
            "points_patient_mm": value.points_patient_mm.tolist(),
            "origin": asdict(value.origin),
        }
        return {"goals.json": to_json(fields), "goals.mrk.json": to_json(write_markups(points))}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> Goals:
        """Return the goals of `encode`, equal in every field."""
        told = json.loads(files["goals.json"])
        return Goals(
            tuple(told["names"]),
            np.array(told["cells"], np.int64).reshape(-1, 3),
            np.array(told["goals"], np.int64),
            np.array(told["points_patient_mm"], float).reshape(-1, 3),
            read_origin(told["origin"]),
        )
