"""One checkout: its catalog, cases, pipelines, store, and the job that a case asks for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from catalog.cases import Case, list_cases, load_case, resolve_input
from catalog.datasets import Dataset, load_catalog
from catalog.store import Store
from catalog.validation import unknown, validate
from catalog.yaml_file import load_mapping, load_value, value_text
from nodes.errors import BadInput
from nodes.reporting.artefacts import ChangedParameter
from pipelines.kernel_cache import use_kernel_cache
from pipelines.node_facts import NodeReader
from pipelines.registry import PIPELINES
from pipelines.stage import Stage


@dataclass(frozen=True)
class Job:
    """A case ready to be planned: stages in order, parameters of each, where the inputs are."""

    case: Case
    stages: tuple[Stage, ...]
    parameters: Mapping[str, BaseModel]
    changed: tuple[ChangedParameter, ...]
    inputs: Mapping[str, Path]
    absent: tuple[str, ...] = ()  # optional inputs that the case does not bring


class Project:
    """The folder that holds catalog/, nodes/, pipelines/, data/ and reports/."""

    def __init__(self, root: Path | None = None) -> None:
        self.root = root or Path(__file__).resolve().parent.parent
        use_kernel_cache(self.root)
        self.data = self.root / "data"
        self.runs = self.data / "runs"
        self.store = Store(self.data / "store")
        self.cases_folder = self.root / "catalog" / "cases"
        # Imported packages -> versions, asked for once: what is loaded stays as it is.
        self.versions: dict[tuple[str, ...], dict[str, str]] = {}

    @cached_property
    def catalog(self) -> dict:
        """The datasets of catalog.yml."""
        return load_catalog(self.root / "catalog" / "catalog.yml")

    @cached_property
    def reader(self) -> NodeReader:
        """What the source says of the nodes."""
        return NodeReader(self.root, self.catalog, self.store.root / "source.json")

    def cases(self) -> list[str]:
        """Return the names of all cases."""
        return list_cases(self.cases_folder)

    def case(self, name: str) -> Case:
        """Return one case, its pipeline known."""
        case = load_case(self.cases_folder, name)
        find_pipeline(case.pipeline)
        return case

    def job(self, name: str, settings: Sequence[str] = ()) -> Job:
        """Return what a case asks for, with `key=value` settings on top of its own parameters.

        Raises
        ------
        BadInput : for anything that a person wrote and a rule forbids.
        """
        return self.job_of(self.case(name), settings)

    def job_of(self, case: Case, settings: Sequence[str] = ()) -> Job:
        """Return what a case asks for that has no file of its own; else as `job`."""
        stages = find_pipeline(case.pipeline)
        written = _add_settings(self, stages, case.parameters, settings)
        for stage in written.keys() - {s.name for s in stages}:
            raise unknown(f"stage in pipeline {case.pipeline}:", stage, [s.name for s in stages])
        parameters, changed = self._parameters(stages, written, f"{case.name}.yml")
        wanted = wanted_inputs(self.catalog, stages)
        inputs = self._inputs(case, wanted)
        absent = tuple(sorted(wanted.keys() - inputs.keys()))
        return Job(case, stages, parameters, changed, inputs, absent)

    def is_ready(self, name: str) -> bool:
        """Return whether all inputs that a case names are on this machine."""
        return all(path.exists() for path in self.job(name).inputs.values())

    def _parameters(
        self, stages: Sequence[Stage], written: Mapping[str, Mapping[str, Any]], where: str
    ) -> tuple[dict[str, BaseModel], tuple[ChangedParameter, ...]]:
        parameters, changed = {}, []
        for stage in stages:
            facts = self.reader.facts(stage)
            if not facts.parameters:
                if stage.name in written:
                    raise unknown(
                        "parameter of", f"{stage.name}.{next(iter(written[stage.name]))}", []
                    )
                continue
            model = facts.parameters_type()
            file = self.root / "catalog" / "parameters" / f"{stage.name}.yml"
            defaults = validate(model, load_mapping(file), file.name)
            values = {**defaults.model_dump(), **written.get(stage.name, {})}
            parameters[stage.name] = validate(model, values, f"{where}: {stage.name}")
            changed += _differences(stage.name, parameters[stage.name], defaults)
        return parameters, tuple(changed)

    def _inputs(self, case: Case, wanted: Mapping[str, bool]) -> dict[str, Path]:
        for name in case.inputs.keys() - wanted.keys():
            raise unknown(f"input of pipeline {case.pipeline}:", name, wanted)
        needed = sorted(name for name, optional in wanted.items() if not optional)
        for name in needed:
            if name not in case.inputs:
                raise BadInput(
                    f"case {case.name} has no input {name}",
                    f"pipeline {case.pipeline} needs {', '.join(needed)}",
                    f"add `{name}: <file or folder>` below `inputs:` in {case.name}.yml",
                )
        variables = {
            "TENDRIL_TEST_DATA": self.root.parent / "shared" / "data",
            "CATALOG": self.root / "catalog",
            "NILEARN_DATA": _package_folder("nilearn") / "datasets" / "data",
        }
        raw = self.data / "raw"
        return {name: resolve_input(path, raw, variables) for name, path in case.inputs.items()}


def wanted_inputs(catalog: Mapping[str, Dataset], stages: Sequence[Stage]) -> dict[str, bool]:
    """Return the inputs that a case of these stages may bring, and whether each is optional."""
    made = {name for stage in stages for name in stage.outputs}
    names = {name for stage in stages for name in stage.inputs if catalog[name].is_input}
    return {name: catalog[name].optional for name in sorted(names - made)}


def _package_folder(name: str) -> Path:
    """Return the folder of an installed package without importing it; its data are files there."""
    spec = find_spec(name)
    return Path(spec.origin).parent if spec and spec.origin else Path(name)


def find_pipeline(name: str) -> tuple[Stage, ...]:
    """Return the stages of a pipeline; a name that is not there is answered with the nearest."""
    if name not in PIPELINES:
        raise unknown("pipeline", name, PIPELINES)
    stages = tuple(PIPELINES[name].STAGES)
    _check_order(name, stages)
    return stages


def _check_order(pipeline: str, stages: Sequence[Stage]) -> None:
    """Refuse stages in which a name stands twice or an output is used before it is made."""
    names = [stage.name for stage in stages]
    outputs = [name for stage in stages for name in stage.outputs]
    twice = {name for name in names if names.count(name) > 1}
    twice |= {name for name in outputs if outputs.count(name) > 1}
    late = set()
    for place, stage in enumerate(stages):
        made_later = {name for other in stages[place:] for name in other.outputs}
        late |= made_later & set(stage.inputs)
    if twice or late:
        raise BadInput(
            f"pipeline {pipeline}: {', '.join(sorted(twice | late))}",
            "each stage and each output has one name, and is made before it is used",
            f"mend the list of stages in pipelines/{pipeline}.py",
        )


def find_stage(stages: Sequence[Stage], name: str) -> Stage:
    """Return a stage by its name; a name that is not there is answered with the nearest."""
    for stage in stages:
        if stage.name == name:
            return stage
    raise unknown("stage", name, [stage.name for stage in stages])


def _add_settings(
    project: Project, stages: Sequence[Stage], written: Mapping, settings: Sequence[str]
) -> dict[str, dict[str, Any]]:
    """Return the case's parameters with `stage.key=value` or, where it is unique, `key=value`."""
    merged = {stage: dict(values or {}) for stage, values in written.items()}
    owners: dict[str, list[str]] = {}
    for stage in stages:
        facts = project.reader.facts(stage)
        for key in facts.parameters_type().model_fields if facts.parameters else ():
            owners.setdefault(key, []).append(stage.name)
            owners[f"{stage.name}.{key}"] = [stage.name]
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals:
            raise BadInput(f"--set {setting}", "it must read key=value", f"--set {key}=...")
        if key not in owners:
            raise unknown("parameter", key, owners)
        if len(owners[key]) > 1:
            choices = ", ".join(f"{stage}.{key}" for stage in owners[key])
            raise BadInput(f"--set {setting}", f"{key} belongs to several stages", f"use {choices}")
        merged.setdefault(owners[key][0], {})[key.rpartition(".")[2]] = load_value(text)
    return merged


def _differences(stage: str, values: BaseModel, defaults: BaseModel) -> list[ChangedParameter]:
    rows = []
    here, before = (model.model_dump(mode="json") for model in (values, defaults))
    for name, field in type(values).model_fields.items():
        if getattr(values, name) != getattr(defaults, name):
            told = (value_text(written[name]) for written in (here, before))
            meaning = " ".join((field.description or "").split())
            rows.append(ChangedParameter(stage, name, *told, meaning))
    return rows
