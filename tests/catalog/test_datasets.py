"""The catalog names what exists, and every parameter file what its stage knows."""

import re
from pathlib import Path

import pytest

from catalog.datasets import FORMATS, Dataset, find_dataset, load_catalog
from catalog.validation import validate
from catalog.yaml_file import load_mapping
from nodes.errors import BadInput
from pipelines.project import Project
from pipelines.registry import PIPELINES
from pipelines.stage import ACCOUNT, Stage
from tests.conftest import ROOT

CATALOG = load_catalog(ROOT / "catalog/catalog.yml")
STAGES = {stage.name: stage for module in PIPELINES.values() for stage in module.STAGES}
READER = Project(ROOT).reader
PARAMETERS = ROOT / "catalog/parameters"


@pytest.mark.parametrize("name", CATALOG)
def test_every_dataset_has_a_format_that_encodes_and_decodes(name: str) -> None:
    dataset = CATALOG[name]
    if dataset.place == "run":
        assert dataset.format is None
        return
    chosen = dataset.load_format()
    assert callable(chosen.encode) and callable(chosen.decode)
    assert dataset.about


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_can_be_imported(name: str) -> None:
    chosen = Dataset(format=name, about="x").load_format()
    assert chosen.__module__.startswith("catalog.formats.") and chosen.__doc__


@pytest.mark.parametrize("name", CATALOG)
def test_every_dataset_stands_in_a_known_place_and_under_a_plain_name(name: str) -> None:
    assert re.fullmatch(r"[a-z0-9_]+", name)
    place = CATALOG[name].place
    assert place in ("store", "input", "run") or re.fullmatch(r"reports/.*\{case\}.*", place)
    assert bool(CATALOG[name].option) <= CATALOG[name].is_input


def test_options_of_inputs_differ() -> None:
    options = [dataset.option for dataset in CATALOG.values() if dataset.option]
    assert len(options) == len(set(options))
    assert all(re.fullmatch(r"--[a-z][a-z-]*", option) for option in options)


@pytest.mark.parametrize("pipeline", PIPELINES)
def test_every_pipeline_makes_each_dataset_once_and_before_it_is_needed(pipeline: str) -> None:
    made: set[str] = {ACCOUNT}
    stages = PIPELINES[pipeline].STAGES
    assert len({stage.name for stage in stages}) == len(stages)
    for stage in stages:
        for name in stage.inputs:
            assert name in made or find_dataset(CATALOG, name).is_input
        for name in stage.outputs:
            assert name not in made and CATALOG[name].format
        made |= set(stage.outputs)


@pytest.mark.parametrize("stage", STAGES.values(), ids=list(STAGES))
def test_every_parameter_file_has_just_the_fields_of_its_stage(stage: Stage) -> None:
    facts = READER.facts(stage)
    file = PARAMETERS / f"{stage.name}.yml"
    assert file.exists() == bool(facts.parameters)
    if facts.parameters:
        model = facts.parameters_type()
        values = load_mapping(file)
        assert list(values) == list(model.model_fields)
        validate(model, values, file.name)
        for name, field in model.model_fields.items():
            assert field.is_required(), f"{name}: defaults stand in YAML only"
            assert field.description, f"{name}: no sentence below the field"


def test_every_parameter_file_belongs_to_a_stage() -> None:
    assert {path.stem for path in PARAMETERS.glob("*")} <= STAGES.keys()


@pytest.mark.parametrize("file", sorted(PARAMETERS.glob("*.yml")), ids=lambda path: path.stem)
def test_above_every_parameter_stands_a_comment(file: Path) -> None:
    lines = file.read_text().splitlines()
    for above, line in zip(["", *lines], lines, strict=False):
        if re.match(r"\w+:", line):
            assert above.startswith("# "), line


def test_an_unknown_dataset_is_answered_with_the_nearest() -> None:
    with pytest.raises(BadInput, match=r"did you mean label_map\?"):
        find_dataset(CATALOG, "labelmap")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("ct: {about: x, format: volumes}", "catalog.yml: ct: format = 'volumes'"),
        ("ct: {about: x, fromat: volume}", "did you mean format?"),
        ("ct: {format: volume}", "about is missing"),
        ("ct: volume", "catalog.yml: ct"),
        ("ct:", "catalog.yml: ct"),
    ],
)
def test_a_broken_entry_is_told(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "catalog.yml"
    path.write_text(text)
    with pytest.raises(BadInput) as caught:
        load_catalog(path)
    assert told in str(caught.value)
