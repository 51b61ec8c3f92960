"""What a run tells of itself, for the page that it makes."""

import os
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path

from nodes.reporting.artefacts import RunAccount, StageAccount
from pipelines.outcomes import Outcome
from pipelines.project import Job, Project
from pipelines.stage import Stage


def tell_run(
    project: Project,
    job: Job,
    hashes: Mapping[str, str],
    outcomes: Mapping[str, Outcome],
    started: str,
) -> RunAccount:
    """Return the account of a run up to now; inputs are described without their paths."""
    packages: dict[str, str] = {"tendril": metadata.version("tendril")}
    for outcome in outcomes.values():
        packages |= outcome.record.made_from["packages"]
    return RunAccount(
        case=job.case.name,
        title=job.case.title,
        pipeline=job.case.pipeline,
        run=started,
        started=started,
        inputs=tuple(
            (name, describe_files(path), hashes[name]) for name, path in job.inputs.items()
        ),
        stages=tuple(_tell_stage(project, s, outcomes.get(s.name)) for s in job.stages),
        changed_parameters=job.changed,
        versions=tuple(sorted(packages.items())),
    )


def _tell_stage(project: Project, stage: Stage, outcome: Outcome | None) -> StageAccount:
    summary = project.reader.facts(stage).summary
    told = stage.name, summary, stage.inputs, stage.outputs
    if outcome is None:
        return StageAccount(*told, "running", (), 0.0, "", ())
    record = outcome.record
    hashes = tuple(record.outputs[name] for name in stage.outputs)
    how = outcome.status, outcome.reasons, record.seconds
    return StageAccount(*told, *how, record.key, hashes)


def describe_files(path: Path) -> str:
    """Return "folder of 133 files, 32.1 MB": names of files may be names of patients."""
    if path.is_file():
        return f"one file, {_tell_size(path.stat().st_size)}"
    sizes = [os.path.getsize(os.path.join(f, n)) for f, _, names in os.walk(path) for n in names]
    return f"folder of {len(sizes)} files, {_tell_size(sum(sizes))}"


def _tell_size(size: int) -> str:
    return f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{size / 1e3:.1f} kB"
