"""What a run tells of itself, for the page that it makes."""

import os
from importlib import metadata
from typing import TYPE_CHECKING

from nodes.reporting.artefacts import RunAccount, StageAccount

if TYPE_CHECKING:
    from pathlib import Path

    from pipelines.engine import Run


def tell_run(run: "Run") -> RunAccount:
    """Return the account of a run up to now; inputs are described without their paths."""
    case = run.job.case
    packages: dict[str, str] = {"tendril": metadata.version("tendril")}
    for outcome in run.outcomes.values():
        packages |= outcome.record.made_from["packages"]
    inputs = tuple(
        (name, describe_files(path), run.hashes[name]) for name, path in run.job.inputs.items()
    )
    return RunAccount(
        case=case.name,
        title=case.title,
        pipeline=case.pipeline,
        run=run.started,
        started=run.started,
        inputs=inputs,
        stages=tuple(_tell_stage(run, stage) for stage in run.job.stages),
        changed_parameters=run.job.changed,
        versions=tuple(sorted(packages.items())),
    )


def _tell_stage(run: "Run", stage) -> StageAccount:
    outcome = run.outcomes.get(stage.name)
    summary = run.project.reader.facts(stage).summary
    if outcome is None:
        return StageAccount(
            stage.name, summary, stage.inputs, stage.outputs, "running", (), 0.0, "", ()
        )
    record = outcome.record
    return StageAccount(
        stage.name,
        summary,
        stage.inputs,
        stage.outputs,
        outcome.status,
        outcome.reasons,
        record.seconds,
        record.key,
        tuple(record.outputs[name] for name in stage.outputs),
    )


def describe_files(path: "Path") -> str:
    """Return "folder of 133 files, 32.1 MB": names of files may be names of patients."""
    if path.is_file():
        return f"one file, {path.stat().st_size / 1e6:.1f} MB"
    sizes = [os.path.getsize(os.path.join(f, n)) for f, _, names in os.walk(path) for n in names]
    return f"folder of {len(sizes)} files, {sum(sizes) / 1e6:.1f} MB"
