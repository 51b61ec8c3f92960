"""The reach that is read from the source holds every function that really runs.

Nodes and formats are called on small data under a profiler: whatever function of the project it
sees must be in the reach, or an edit of it would go unnoticed.
"""

import ast
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from catalog.datasets import FORMATS
from catalog.yaml_file import load_mapping
from nodes.environment.build_occupancy_grid import build_occupancy_grid
from nodes.environment.build_surfaces import build_surfaces
from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.origin import Origin
from nodes.geometry.point_clouds import PointCloud
from nodes.imaging.make_thorax_phantom import make_thorax_phantom
from nodes.imaging.measure_labels import measure_labels
from nodes.imaging.read_volume import read_volume
from nodes.imaging.score_segmentation import score_segmentation
from nodes.imaging.segment_ct import segment_ct
from nodes.reporting.artefacts import Page, RunAccount, Section
from nodes.reporting.build_case_page import build_case_page
from nodes.reporting.show_slices import show_slices
from nodes.reporting.show_surfaces import show_surfaces
from nodes.reporting.show_table import show_table
from pipelines.project import Project
from pipelines.registry import PIPELINES
from pipelines.source_tree import SourceTree
from tests.conftest import ROOT

STAGES = {stage.name: stage for module in PIPELINES.values() for stage in module.STAGES}
TREE = SourceTree(ROOT)
COARSE = {"pixel_spacing_mm": 5.0, "slice_thickness_mm": 8.0}


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


def parameters_of(stage: str, **changed: Any) -> Any:
    model = Project(ROOT).reader.facts(STAGES[stage]).parameters_type()
    return model(**{**load_mapping(ROOT / f"catalog/parameters/{stage}.yml"), **changed})


@cache
def made() -> tuple[dict[str, Any], dict[str, set[str]]]:
    """Return artefacts by name, and what ran to make them by stage."""
    values: dict[str, Any] = {}
    ran: dict[str, set[str]] = {}

    def run(stage: str, outputs: str, function: Callable, *inputs: Any, **changed: Any) -> None:
        parameters = () if not stage_has_parameters(stage) else (parameters_of(stage, **changed),)
        result, ran[stage] = called_by(lambda: function(*inputs, *parameters))
        names = outputs.split()
        values.update(zip(names, result if len(names) > 1 else [result], strict=True))

    run("make_thorax_phantom", "image_files truth", make_thorax_phantom, **COARSE)
    run("read_volume", "ct", read_volume, values["image_files"])
    run("segment_ct", "label_map", segment_ct, values["ct"])
    run("measure_labels", "table", measure_labels, values["label_map"])
    run("score_segmentation", "scores", score_segmentation, values["label_map"], values["truth"])
    run("build_occupancy_grid", "grid", build_occupancy_grid, values["label_map"], voxel_size_mm=6)
    run("build_surfaces", "surfaces", build_surfaces, values["label_map"], voxel_size_mm=8)
    run("show_surfaces", "section", show_surfaces, values["surfaces"])
    run("show_slices", "slices", show_slices, values["ct"], values["label_map"], pixels=32)
    run("show_measures", "measures", show_table, values["table"])
    account = RunAccount("c", "t", "p", "1", "now", (), (), (), ())

    def page(parameters: Any) -> Any:
        return build_case_page(values["section"], values["slices"], run_account=account,
                               parameters=parameters)  # fmt: skip

    run("build_case_page", "page", page)
    return values, ran


def stage_has_parameters(stage: str) -> bool:
    return bool(Project(ROOT).reader.facts(STAGES[stage]).parameters)


PROFILED = ("make_thorax_phantom", "read_volume", "segment_ct", "measure_labels",
            "score_segmentation", "build_occupancy_grid", "build_surfaces", "show_surfaces",
            "show_slices", "show_measures", "build_case_page")  # fmt: skip


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
    value = made()[0]["image_files"] if name == "image_files" else small_values()[name]
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
