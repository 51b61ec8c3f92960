"""Prefect around the engine: one flow a case, one task a stage, and the schedules."""

import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

from prefect import flow, serve, task
from prefect.artifacts import create_link_artifact
from prefect.cache_policies import NO_CACHE
from prefect.schedules import Cron, Interval
from prefect.states import Completed, Failed, State

from pipelines.deployments import Deployment, Schedule, load_deployments
from pipelines.engine import Run
from pipelines.outcomes import CACHED
from pipelines.project import Project
from pipelines.running import run_case, runnable_cases
from pipelines.stage import Stage

# Tells the processes of scheduled runs who started them.
_SERVER = "TENDRIL_SERVER_PID"


class StageFailed(RuntimeError):
    """All that Prefect's database learns of a failure: an error's own words may name files."""


def drive(run: Run, stages: Sequence[Stage]) -> None:
    """Go through the stages as tasks of one Prefect flow; errors come out as they are."""
    failures: list[BaseException] = []

    def go() -> State:
        for stage in stages:
            _task(run, stage, failures)()
        return Completed(message=f"{len(stages)} stages up to date")

    case = run.job.case
    try:
        flow(name=case.pipeline, flow_run_name=case.name, persist_result=False)(go)()
    except StageFailed:
        raise failures[0] from None


def _task(run: Run, stage: Stage, failures: list[BaseException]) -> Callable[[], Any]:
    summary = run.project.reader.facts(stage).summary

    @task(name=stage.name, description=summary, cache_policy=NO_CACHE, persist_result=False)
    def do_stage() -> State:
        try:
            outcome = run.do(stage)
        except Exception as error:
            failures.append(error)
            raise StageFailed(f"{type(error).__name__} in {stage.name}") from None
        _link_pages(run, stage)
        if outcome.status == CACHED:
            return Completed(name="Cached", message="from cache")
        return Completed(message=f"computed in {outcome.record.seconds:.2f} s")

    return do_stage


def _link_pages(run: Run, stage: Stage) -> None:
    """Link the case's page in Prefect's own pages."""
    for name in stage.outputs:
        place = run.project.catalog[name].place
        if place.startswith("reports/"):
            path = run.project.root / place.format(case=run.job.case.name)
            create_link_artifact(
                link=path.as_uri(),
                link_text=f"{name} of {run.job.case.name}",
                key=f"{name}-{run.job.case.name}".replace("_", "-"),
            )


@flow(name="tendril", persist_result=False)
def run_cases(pipeline: str = "", cases: Sequence[str] = (), settings: Sequence[str] = ()) -> State:
    """Bring cases up to date: those named, or all whose inputs are on this machine.

    Parameters
    ----------
    pipeline : only cases of this pipeline; all where empty.
    cases : names of cases; all where empty.
    settings : `key=value` on top of each case's own parameters.
    """
    project = Project()
    names = runnable_cases(project, pipeline, cases)
    failed = [name for name in names if not _bring_up_to_date(project, name, settings)]
    if failed:
        return Failed(message=f"failed: {', '.join(failed)}")
    return Completed(message=f"{len(names)} cases up to date")


def _end_with_parent() -> None:
    """In a process that a schedule started: end when the server that started it is killed."""
    server = int(os.environ.get(_SERVER, 0))
    if not server:
        return

    def watch() -> None:
        while os.getppid() == server:
            time.sleep(1)
        os.kill(os.getpid(), signal.SIGKILL)  # the store holds nothing half-written

    threading.Thread(target=watch, daemon=True).start()


def _bring_up_to_date(project: Project, name: str, settings: Sequence[str]) -> bool:
    """Run one case of several: one that fails must not stop the others."""
    try:
        run_case(project, name, settings, driver=drive, always=True)
    except Exception as error:  # its words may name a patient's files, and this goes to a log
        print(f"{name}: failed, {type(error).__name__}; `tendril run --case {name}` tells more")
        return False
    return True


def serve_schedules(project: Project) -> None:
    """Serve the deployments of prefect.yaml until stopped."""
    os.environ[_SERVER] = str(os.getpid())
    serve(*(_deployment(entry) for entry in load_deployments(project.root / "prefect.yaml")))


def _deployment(entry: Deployment) -> Any:
    return run_cases.to_deployment(
        entry.name,
        description=entry.description,
        parameters=entry.parameters.model_dump(),
        schedules=[_schedule(schedule) for schedule in entry.schedules],
        concurrency_limit=entry.concurrency_limit,
    )


def _schedule(entry: Schedule) -> Any:
    if entry.cron:
        return Cron(entry.cron, timezone=entry.timezone)
    return Interval(entry.interval, timezone=entry.timezone)


# When it is loaded, not when the flow begins: a run that waits for its turn must end, too.
_end_with_parent()
