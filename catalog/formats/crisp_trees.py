"""Trees of configurations as .vtp that ParaView opens: cameras as points, edges as lines.

What a node is stands in the point's data, which also restores the tree bit by bit.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict

import numpy as np

from catalog.formats.placed_setups import PlacedSetupsFormat
from catalog.formats.plain_values import (
    plain_figures,
    read_figures,
    read_origin,
    tell_origin,
    to_json,
)
from catalog.formats.vtp_arrays import PointTable, read_points, write_points
from nodes.mechanics.describe_robots import name_needle
from nodes.planning.artefacts import CrispTree, CrispTrees, PlacedSetup, PlacedSetups

_SETUPS = "setups/"
# Columns of the file and fields of the tree.
_NODES = {
    "parent": "parents",
    "steps": "steps",
    "view": "views",
    "seconds": "seconds",
    "tree": "trees",
}


class CrispTreesFormat:
    """`tree_1.vtp` and so on, `trees.json`, and `setups/` with the files of placed setups."""

    @staticmethod
    def encode(value: CrispTrees) -> dict[str, bytes]:
        """Return all files."""
        trees = {
            f"tree_{number}.vtp": _write(tree, tell_origin(value.origin))
            for number, tree in enumerate(value.trees, start=1)
        }
        told = {
            "trees": [
                {"ending": tree.ending, "counts": plain_figures(tree.counts)}
                for tree in value.trees
            ],
            "origin": asdict(value.origin),
        }
        setups = PlacedSetups(tuple(tree.placed for tree in value.trees), value.origin)
        placed = {_SETUPS + k: v for k, v in PlacedSetupsFormat.encode(setups).items()}
        return {**trees, **placed, "trees.json": to_json(told)}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> CrispTrees:
        """Return the trees of `encode`, equal in every field."""
        told = json.loads(files["trees.json"])
        own = {k.removeprefix(_SETUPS): v for k, v in files.items() if k.startswith(_SETUPS)}
        setups = PlacedSetupsFormat.decode(own).setups
        trees = tuple(
            _read(files[f"tree_{number}.vtp"], placed, each)
            for number, (placed, each) in enumerate(zip(setups, told["trees"], strict=True), 1)
        )
        return CrispTrees(trees, read_origin(told["origin"]))


def _write(tree: CrispTree, notes: list[str]) -> bytes:
    nodes = {column: getattr(tree, field) for column, field in _NODES.items()}
    parts = {}
    for needle in range(len(tree.placed.setup.needles)):
        name = name_needle(needle)
        parts[f"{name} quaternion_wxyz"] = tree.quaternions[:, needle]
        parts[f"{name} length_mm"] = tree.lengths_mm[:, needle]
        parts[f"{name} moment_n_mm"] = tree.wrenches[:, needle, :3]
        parts[f"{name} force_n"] = tree.wrenches[:, needle, 3:]
    children = np.flatnonzero(tree.parents >= 0)
    edges = np.stack([tree.parents[children], children], axis=1)
    table = PointTable(tree.cameras_patient_mm, nodes | parts, {"seeing": tree.seeing})
    return write_points(table, edges, notes)


def _read(content: bytes, placed: PlacedSetup, told: Mapping) -> CrispTree:
    table = read_points(content)
    names = [name_needle(needle) for needle in range(len(placed.setup.needles))]

    def stack(column: str) -> np.ndarray:
        return np.stack([table.columns[f"{name} {column}"] for name in names], axis=1)

    return CrispTree(
        placed=placed,
        quaternions=stack("quaternion_wxyz"),
        lengths_mm=stack("length_mm"),
        wrenches=np.concatenate([stack("moment_n_mm"), stack("force_n")], axis=2),
        cameras_patient_mm=table.points,
        seeing=table.fields["seeing"],
        ending=told["ending"],
        counts=read_figures(told["counts"]),
        **{field: table.columns[column] for column, field in _NODES.items()},
    )
