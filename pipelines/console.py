"""What the command line prints of runs and plans, one case after the other."""

import os
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from catalog.store import StoreFailure
from nodes.errors import BadInput
from pipelines.engine import Observer, Run
from pipelines.history import History
from pipelines.outcomes import FRESH, Planned
from pipelines.progress import Progress, expected_seconds
from pipelines.project import Project
from pipelines.running import Driver, Watch, is_of, run_case
from pipelines.selection import Selection
from pipelines.stage import Stage


def tell_absent(project: Project, pipeline: str, names: Sequence[str]) -> None:
    """Say which cases are skipped, and why."""
    for name in project.cases():
        if name in names or not is_of(project.case(name).pipeline, pipeline):
            continue
        if project.case(name).on_request and not pipeline:
            print(f"{name}: skipped, it runs on request: tendril run --case {name}")
        else:
            print(f"{name}: skipped, its inputs are not on this machine")


def survive(work: Callable[[], None]) -> int:
    """Do some work, tell what goes wrong, and return the exit code that stands for it."""
    try:
        work()
    except BadInput as error:
        print(f"error: {error}", file=sys.stderr, flush=True)
        return error.exit_code
    except OSError as error:
        print(f"error: {explain_disk(error)}", file=sys.stderr, flush=True)
        return StoreFailure.exit_code
    except Exception:
        traceback.print_exc()
        print(
            "failed; what is finished is kept, and the next run goes on from there", file=sys.stderr
        )
        return 1
    return 0


def explain_disk(error: OSError) -> StoreFailure:
    """Return what to tell of a disk that refuses; never the name of a file, which may be a name."""
    return StoreFailure(
        f"the disk refused: {error.strerror or type(error).__name__}",
        "the folders data and reports must be writable and have room",
        "make room or mend their permissions, and run again",
    )


def run_one(
    project: Project, name: str, settings: Sequence[str], selection: Selection, driver: Driver
) -> None:
    """Bring one case up to date and tell what happens."""
    with ExitStack() as open_things:
        watch = show_progress(name, open_things)
        done = run_case(project, name, settings, selection, driver=driver, watch=watch)
    ended = (
        "nothing to do, all is fresh" if done.folder is None else f"done, {done.computed} computed"
    )
    print(f"{name}: {ended}")
    for page in History(project, name).latest().get("published", {}):
        print(f"  page  {near(project.root / page)}")
    print(f"  data  {near(project.runs / name / 'latest')}")


def show_progress(name: str, open_things: ExitStack) -> Watch:
    """Return what tells the title and the progress of a run once its plan stands."""

    def watch(run: Run, plan: Sequence[Planned], stages: Sequence[Stage]) -> Observer:
        print(f"{name}: {run.job.case.title}", flush=True)
        expected = expected_seconds(stages, run.history.seconds())
        expected |= {p.stage.name: 0.0 for p in plan if p.state == FRESH}
        return open_things.enter_context(Progress(name, stages, expected)).observe

    return watch


def prefect_driver(project: Project, open_things: ExitStack) -> Driver:
    """Return a driver that starts Prefect when it is first called, and keeps it for all cases."""
    address = ""

    def drive(run: Run, stages: Sequence) -> None:
        nonlocal address
        if not address:
            from pipelines.server import prefect_server

            address = open_things.enter_context(prefect_server(project.data))
        from pipelines.flows import drive as drive_flow

        drive_flow(run, stages)

    return drive


def near(path: Path) -> str:
    """Return a path as seen from where the person stands."""
    return os.path.relpath(path)


def tell_status(project: Project, name: str, settings: Sequence[str], verify: bool) -> list[str]:
    """Tell the state of each stage of one case, and return the states."""
    run = Run(project, project.job(name, settings))
    if verify:
        run.verify()
    plan = run.plan()
    print(f"{name}  ({run.job.case.pipeline})")
    for planned in plan:
        why = f"  {'; '.join(planned.reasons)}" if planned.reasons else ""
        print(f"  {planned.state:9}  {planned.stage.name}{why}")
    return [planned.state for planned in plan]
