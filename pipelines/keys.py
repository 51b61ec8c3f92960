"""The key of a stage: the hash of all that its result depends on, and what differs between two."""

import json
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

from pipelines.project import Job, Project
from pipelines.stage import ACCOUNT, Stage
from pipelines.versions import package_versions


def made_from(
    project: Project, job: Job, stage: Stage, hashes: Mapping[str, str]
) -> dict[str, Any]:
    """Return, part by part, what a stage's result depends on.

    Parameters
    ----------
    hashes : dataset -> content hash; must hold every input of the stage.
    """
    facts = project.reader.facts(stage)
    parameters = job.parameters.get(stage.name)
    known = {**hashes, ACCOUNT: _account_identity(project, job, hashes)}
    datasets = (*stage.inputs, *stage.outputs)
    return {
        "function": stage.target,
        "code": facts.code,
        "parameters": parameters.model_dump(mode="json") if parameters else {},
        "inputs": {argument: known[name] for argument, name in stage.arguments.items()},
        "outputs": list(stage.outputs),
        "formats": {name: project.catalog[name].format for name in datasets},
        "packages": _versions(project, stage),
    }


def key_of(parts: Mapping[str, Any]) -> str:
    """Return the key of what `made_from` returned."""
    return sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def _account_identity(project: Project, job: Job, hashes: Mapping[str, str]) -> str:
    """Return a hash of what an account tells, but for when and how fast it was and what was cached.

    So a page is made anew when anything that it shows has changed, and not because its stages came
    from the cache this time.
    """
    changed = [[c.stage, c.name, c.value, c.default, c.meaning] for c in job.changed]
    stages = [_stage_identity(project, stage) for stage in job.stages]
    teller = Path(__file__).with_name("account.py").read_text("utf-8")
    case = [job.case.name, job.case.title, job.case.pipeline]
    told = [case, changed, stages, dict(hashes), teller]
    return sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def _stage_identity(project: Project, stage: Stage) -> list:
    facts = project.reader.facts(stage)
    return [stage.name, facts.summary, stage.inputs, stage.outputs, _versions(project, stage)]


def _versions(project: Project, stage: Stage) -> dict[str, str]:
    packages = tuple(project.reader.facts(stage).packages)
    if packages not in project.versions:
        memory = project.store.root / "packages.json"
        project.versions[packages] = package_versions(packages, memory)
    return project.versions[packages]


def differences(
    before: Mapping[str, Any], now: Mapping[str, Any], datasets: Mapping[str, str]
) -> list[str]:
    """Return in words what changed between two results of `made_from`.

    Parameters
    ----------
    datasets : argument -> dataset, to name inputs as people know them.
    """
    reasons = [
        f"parameter {name}: {old} -> {new}"
        for name, old, new in _changes(before["parameters"], now["parameters"])
    ]
    inputs = [datasets.get(name, name) for name, _, _ in _changes(before["inputs"], now["inputs"])]
    reasons += [f"input {name} changed" for name in inputs if name != ACCOUNT]
    for name, old, new in _changes(before["code"], now["code"]):
        verb = "is new" if old is None else "is gone" if new is None else "was edited"
        reasons.append(f"code {name.removeprefix('nodes.')} {verb}")
    for name, old, new in _changes(before["packages"], now["packages"]):
        reasons.append(f"package {name}: {old or 'none'} -> {new or 'none'}")
    for part in ("function", "outputs", "formats"):
        if before[part] != now[part]:
            reasons.append(f"the stage's {part} changed")
    if ACCOUNT in inputs and not reasons:
        reasons.append("what it tells of the run has changed")
    return reasons


def _changes(before: Mapping, now: Mapping) -> list[tuple[str, Any, Any]]:
    names = sorted(before.keys() | now.keys())
    return [(n, before.get(n), now.get(n)) for n in names if before.get(n) != now.get(n)]
