"""Bringing a case up to date: plan first, and start Prefect only where something is stale."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from nodes.errors import BadInput
from pipelines.engine import Observer, Run
from pipelines.history import COMPLETE, FAILED, INTERRUPTED
from pipelines.index import publish_index
from pipelines.outcomes import FRESH, Planned
from pipelines.project import Job, Project, find_pipeline
from pipelines.selection import Selection
from pipelines.stage import Stage

Driver = Callable[[Run, Sequence[Stage]], None]
Watch = Callable[[Run, Sequence[Planned], Sequence[Stage]], Observer]


@dataclass(frozen=True)
class CaseRun:
    """How a run of a case ended: how many stages were computed, and where its record lies."""

    case: str
    computed: int
    folder: Path | None


def runnable_cases(project: Project, pipeline: str = "", cases: Sequence[str] = ()) -> list[str]:
    """Return the cases to run: those named, or all of a pipeline and its variants whose
    inputs are here.

    Raises
    ------
    BadInput : for a pipeline that does not exist, or a named case that does not.
    """
    if pipeline:
        find_pipeline(pipeline)
    if cases:
        return [name for name in cases if is_of(project.case(name).pipeline, pipeline)]
    return [name for name in project.cases() if _may_run(project, name, pipeline)]


def is_of(pipeline: str, asked: str) -> bool:
    """Return whether a pipeline is the one that was asked for, or a variant of it, whose name goes
    on from it; who asks for none, asks for all."""
    return not asked or pipeline == asked or pipeline.startswith(f"{asked}_")


def _may_run(project: Project, name: str, pipeline: str) -> bool:
    """Return whether a case is of the pipeline, runs without being asked for where none is named,
    and its inputs are here.

    One that breaks a rule may run too: so its error is told, and the other cases still run.
    """
    try:
        case = project.case(name)
        if not is_of(case.pipeline, pipeline) or (case.on_request and not pipeline):
            return False
        return project.is_ready(name)
    except BadInput:
        return True


def run_plainly(run: Run, stages: Sequence[Stage]) -> None:
    """Go through the stages in plain Python."""
    for stage in stages:
        run.do(stage)


def run_case(
    project: Project,
    name: str,
    settings: Sequence[str] = (),
    selection: Selection = Selection(),  # noqa: B008 - frozen
    *,
    driver: Driver = run_plainly,
    watch: Watch | None = None,
    always: bool = False,
) -> CaseRun:
    """Bring one case up to date and note the run; the arguments are those of `run_job`."""
    job = project.job(name, settings)
    return run_job(project, job, selection, driver=driver, watch=watch, always=always)


def run_job(
    project: Project,
    job: Job,
    selection: Selection = Selection(),  # noqa: B008 - frozen
    *,
    driver: Driver = run_plainly,
    watch: Watch | None = None,
    always: bool = False,
) -> CaseRun:
    """Bring the stages of a job up to date and note the run.

    Parameters
    ----------
    driver : goes through the stages when something is stale; plain Python, or Prefect.
    watch : told the plan once it stands; returns the observer of the run.
    always : use the driver even where nothing is stale.
    """
    with project.store.in_use():
        project.store.sweep()
        run = Run(project, job, selection)
        plan = run.plan()
        stages = run.check_selection(plan)
        stale = [p for p in plan if p.state != FRESH and p.stage in stages]
        if not stale and not always:
            driver = run_plainly
            keys = {p.stage.name: p.record.key for p in plan if p.record and p.stage in stages}
            if run.history.is_current(keys):
                publish_index(project)
                return CaseRun(job.case.name, 0, None)
        if watch:
            run.observe = watch(run, plan, stages)
        return CaseRun(job.case.name, *_go(run, stages, driver))


def _go(run: Run, stages: Sequence[Stage], driver: Driver) -> tuple[int, Path]:
    try:
        driver(run, stages)
    except BaseException as error:
        status = FAILED if isinstance(error, Exception) else INTERRUPTED
        _keep_what_is_done(run, status, type(error).__name__)
        raise
    folder = run.keep(COMPLETE)
    run.project.store.signatures.save()
    publish_index(run.project)
    return sum(o.status == "computed" for o in run.outcomes.values()), folder


def _keep_what_is_done(run: Run, status: str, error: str) -> None:
    """Note a run that did not end; where even that fails, the first error is the one to tell."""
    try:
        run.keep(status, error)
        run.project.store.signatures.save()
        publish_index(run.project)
    except (OSError, BadInput):
        return
