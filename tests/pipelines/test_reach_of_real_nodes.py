"""The reach that is read from the source holds every function that really runs.

Nodes and formats are called on small data under a profiler: whatever function of the project it
sees must be in the reach, or an edit of it would go unnoticed.
"""

import ast
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from catalog.datasets import FORMATS
from catalog.formats.label_files import LabelFilesFormat
from catalog.formats.labelmap import LabelMapFormat
from catalog.formats.placed_setups import PlacedSetupsFormat
from catalog.yaml_file import load_mapping
from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.label_files import LabelFiles
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.origin import Origin
from nodes.geometry.point_clouds import PointCloud
from nodes.geometry.sites import Sites
from nodes.reporting.artefacts import Page, RunAccount, Section
from pipelines.project import Project
from pipelines.registry import PIPELINES
from pipelines.source_tree import SourceTree
from pipelines.stage import Stage
from tests.conftest import ROOT

STAGES = {stage.name: stage for module in PIPELINES.values() for stage in module.STAGES}
TREE = SourceTree(ROOT)
READER = Project(ROOT).reader
PHANTOM = {stage.name: stage for stage in PIPELINES["pleuroscopy_phantom"].STAGES}
MORE = [stage for stage in PIPELINES["thorax_phantom"].STAGES if stage.name not in PHANTOM]
PHANTOM |= {stage.name: stage for stage in MORE}
# Coarse, so that all of it takes seconds.
QUICK = {
    "make_thorax_phantom": {"pixel_spacing_mm": 3.0, "slice_thickness_mm": 5.0},
    "build_effusion_grid": {"voxel_size_mm": 4},
    "build_fine_effusion_grid": {"voxel_size_mm": 4},
    "find_entry_corridors": {"candidate_spacing_mm": 40},
    "build_surfaces": {"voxel_size_mm": 6, "voxel_size_mm_by_label": {}},
    "sample_point_cloud": {"spacing_mm": 10},
    "show_slices": {"pixels": 32},
    "show_labels": {"pixels": 32},
    "place_goals": {"random_goals": 2},
    "search_crisp_setups": {"coarsest_cell": 10, "two_needles": 2, "three_needles": 0,
                            "rounds": 1, "setups": 1, "node_limit": 32, "directions": 6},
    "grow_crisp_trees": {"coarsest_cell": 10, "node_limit": 200},
    "plan_crisp_motions": {"coarsest_cell": 10},
}  # fmt: skip


def top_of(file: str, line: int) -> str:
    """Return the top-level definition that a line stands in, "" where it is in none."""
    for statement in ast.parse(Path(file).read_bytes()).body:
        first = min(
            [statement.lineno, *(d.lineno for d in getattr(statement, "decorator_list", []))]
        )
        if first <= line <= statement.end_lineno:
            return getattr(statement, "name", "")
    return ""


def called_by(act: Callable[[], Any]) -> tuple[Any, set[str]]:
    """Return what a call gives, and the project's definitions whose functions ran."""
    places = set()

    def watch(frame: Any, event: str, argument: Any) -> None:
        code = frame.f_code
        if (
            event == "call"
            and code.co_name != "<module>"
            and code.co_filename.startswith(str(ROOT))
        ):
            places.add((code.co_filename, code.co_firstlineno))

    sys.setprofile(watch)
    try:
        value = act()
    finally:
        sys.setprofile(None)
    names = set()
    for file, line in places:
        module = ".".join(Path(file).relative_to(ROOT).with_suffix("").parts)
        if module.startswith(("nodes.", "catalog.")) and (top := top_of(file, line)):
            names.add(f"{module}.{top}")
    return value, names


def parameters_of(stage: Stage) -> dict[str, Any]:
    """Return the argument `parameters` of a stage that has one."""
    facts = READER.facts(stage)
    if not facts.parameters:
        return {}
    defaults = load_mapping(ROOT / f"catalog/parameters/{stage.name}.yml")
    return {"parameters": facts.parameters_type()(**{**defaults, **QUICK.get(stage.name, {})})}


def call_stage(stage: Stage, values: dict[str, Any]) -> set[str]:
    """Put what a stage makes to the values; return the definitions that ran."""
    module, _, name = stage.target.partition(":")
    function = getattr(import_module(module), name)
    known = READER.facts(stage).arguments
    given = {argument: values[dataset] for argument, dataset in stage.arguments.items()}
    named = {argument: value for argument, value in given.items() if argument in known}
    more = [value for argument, value in given.items() if argument not in known]
    named |= parameters_of(stage)
    result, ran = called_by(lambda: function(*more, **named))
    outputs = result if len(stage.outputs) > 1 else [result]
    values |= dict(zip(stage.outputs, outputs, strict=True))
    return ran


@cache
def made() -> tuple[dict[str, Any], dict[str, set[str]]]:
    """Return artefacts by name, and what ran to make them by stage."""
    account = RunAccount("c", "t", "p", "1", "now", (), (), (), ())
    values: dict[str, Any] = {
        "label_files": LabelFiles(),
        "run_account": account,
        "sites": Sites(),
        "given_setups": PlacedSetupsFormat.decode({}),
    }
    ran = {stage.name: call_stage(stage, values) for stage in PHANTOM.values()}
    scanned = {"scanned_ct": values["ct"], "scanned_label_map": healthy(values["label_map"])}
    ran["collapse_lung"] = call_stage(STAGES["collapse_lung"], dict(scanned))
    files = LabelMapFormat.encode(values["label_map"])
    drawn = values | {"label_files": LabelFilesFormat.decode(files)}
    marked = Sites(point_names=("target",), points_patient_mm=np.zeros((1, 3)))
    for stage in PIPELINES["label_maps"].STAGES:
        if stage.name in ("combine_label_maps", "check_sites", "show_sites", "show_labels"):
            ran[stage.name] = call_stage(stage, drawn | {"sites": marked})
    return values, ran


def healthy(label_map: LabelMap) -> LabelMap:
    """Return the map with the effusion counted to the lung within it."""
    lung, fluid = (label_map.names.index(name) + 1 for name in ("right_lung", "effusion"))
    voxels = np.where(label_map.voxels == fluid, lung, label_map.voxels).astype(np.uint8)
    return replace(label_map, voxels=voxels)


PROFILED = (
    *PHANTOM,
    "collapse_lung",
    "combine_label_maps",
    "check_sites",
    "show_sites",
    "show_labels",
)


@pytest.mark.parametrize("stage", PROFILED)
def test_every_function_that_a_node_calls_is_in_its_reach(stage: str) -> None:
    ran = made()[1][stage]
    assert STAGES[stage].target.replace(":", ".") in ran
    assert ran <= TREE.reach(STAGES[stage].target).definitions.keys()


def small_values() -> dict[str, Any]:
    origin = Origin("a", True, ("b",))
    corners = np.eye(3, dtype="float32")
    grid = np.arange(8, dtype="int16").reshape(2, 2, 2)
    return {
        "volume": Volume(grid, np.eye(4), "HU", origin),
        "labelmap": LabelMap(grid.astype("uint8"), np.eye(4), ("a", "b"), origin),
        "mesh": Surfaces((("a", Mesh(corners, np.array([[0, 1, 2]], "int32"))),), origin),
        "point_cloud": PointCloud(corners, corners, np.ones(3, "uint8"), ("a",), origin),
        "table": pd.DataFrame({"a": [1.0], "b": ["x"]}),
        "record": {"a": 1},
        "section": Section("t", "<p>", ("w",)),
        "page": Page("<p>"),
    }


@pytest.mark.parametrize("name", [*small_values(), "image_files"])
def test_every_function_that_a_format_calls_is_in_its_reach(name: str) -> None:
    value = made()[0]["ct_files"] if name == "image_files" else small_values()[name]
    module, _, title = FORMATS[name].partition(":")
    chosen = getattr(sys.modules.get(module) or __import__(module, fromlist=[title]), title)
    files, wrote = called_by(lambda: chosen.encode(value))
    _, read = called_by(lambda: chosen.decode(files))
    assert f"{module}.{title}" in wrote & read
    assert wrote | read <= TREE.reach(FORMATS[name]).definitions.keys()


def test_reach_is_far_from_everything() -> None:
    """Else all of the above would hold of a reach that reruns each stage after each edit."""
    every = {
        f"{name}.{definition}"
        for name in TREE.names_below("nodes")
        if (module := TREE.module(name))
        for definition in module.definitions
    }
    for stage in STAGES.values():
        reached = TREE.reach(stage.target).definitions.keys()
        assert len(reached & every) < len(every) / 3, stage.name
