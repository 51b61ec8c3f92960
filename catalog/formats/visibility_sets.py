"""What cameras see of a surface: label maps for 3D Slicer, points with times for ParaView."""

import json
from collections.abc import Mapping
from dataclasses import asdict

import numpy as np
from jaxtyping import Bool

from catalog.formats.labelmap import LabelMapFormat
from catalog.formats.plain_values import FRAME, read_origin, tell_origin, to_json
from catalog.formats.vtp_arrays import PointTable, read_points, write_points
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap
from nodes.visibility.artefacts import VisibilitySet, VisibilitySets

_SEEN = ("seen", "not seen")


class VisibilitySetsFormat:
    """`seen_1.seg.nrrd` of each setup, `seen_by_any.seg.nrrd`, `cells.vtp`, `visibility.json`.

    The points of `cells.vtp` are the surface's cells; what is told of them restores the sets.
    """

    @staticmethod
    def encode(value: VisibilitySets) -> dict[str, bytes]:
        """Return all files."""
        seen = [each.first_nodes >= 0 for each in value.sets]
        maps = {f"seen_{number}": cells for number, cells in enumerate(seen, start=1)}
        if seen:
            maps["seen_by_any"] = np.any(seen, axis=0)
        told = {
            "frame": FRAME,
            "names": [each.name for each in value.sets],
            "patient_from_index": value.patient_from_index.tolist(),
            "shape": value.shape,
            "reading": value.reading,
            "origin": asdict(value.origin),
        }
        return {
            **{f"{name}.seg.nrrd": _write_map(value, cells) for name, cells in maps.items()},
            "cells.vtp": _write_cells(value),
            "visibility.json": to_json(told),
        }

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> VisibilitySets:
        """Return the sets of `encode`, equal in every field."""
        told, table = json.loads(files["visibility.json"]), read_points(files["cells.vtp"])
        return VisibilitySets(
            table.columns["index"],
            np.array(told["patient_from_index"], float),
            tuple(told["shape"]),
            told["reading"],
            tuple(
                VisibilitySet(
                    name, table.columns[f"first_node_{number}"], table.fields[f"seconds_{number}"]
                )
                for number, name in enumerate(told["names"], start=1)
            ),
            read_origin(told["origin"]),
        )


def _write_map(value: VisibilitySets, seen: Bool[np.ndarray, "cell"]) -> bytes:
    labels = np.zeros(value.shape, np.uint8)
    labels[tuple(value.cells.T)] = np.where(seen, 1, 2)
    told = LabelMap(labels, value.patient_from_index, _SEEN, value.origin)
    return LabelMapFormat.encode(told)["labels.seg.nrrd"]


def _write_cells(value: VisibilitySets) -> bytes:
    columns, fields = {"index": value.cells}, {}
    for number, each in enumerate(value.sets, start=1):
        columns[f"first_node_{number}"] = each.first_nodes
        columns[f"first_second_{number}"] = _first_seconds(each)
        fields[f"seconds_{number}"] = each.seconds
    points = transform_points(value.patient_from_index, value.cells.astype(float))
    table = PointTable(points, columns, fields)
    return write_points(table, np.empty((0, 2), np.int64), tell_origin(value.origin))


def _first_seconds(each: VisibilitySet) -> np.ndarray:
    """Return when each cell was seen first, s; -1 for those that never were."""
    seconds = np.full(len(each.first_nodes), -1.0)
    seen = each.first_nodes >= 0
    seconds[seen] = each.seconds[each.first_nodes[seen]]
    return seconds
