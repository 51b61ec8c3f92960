"""What the command line prints of runs and plans, one case after the other."""

import os
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from nodes.errors import BadInput
from pipelines.engine import Run
from pipelines.history import History
from pipelines.progress import Progress, expected_seconds
from pipelines.project import Project
from pipelines.running import Driver, run_case
from pipelines.selection import Selection


def tell_absent(project: Project, pipeline: str, names: Sequence[str]) -> None:
    """Say which cases are skipped, since their inputs are elsewhere."""
    for name in project.cases():
        if name not in names and (not pipeline or project.case(name).pipeline == pipeline):
            print(f"{name}: skipped, its inputs are not on this machine")


def survive(work: Callable[[], None]) -> int:
    """Do the work of one case and return its exit code: one that fails must not stop the others."""
    try:
        work()
    except BadInput as error:
        print(f"error: {error}", file=sys.stderr, flush=True)
        return error.exit_code
    except Exception:
        traceback.print_exc()
        print(
            "failed; what is finished is kept, and the next run goes on from there", file=sys.stderr
        )
        return 1
    return 0


def run_one(
    project: Project, name: str, settings: Sequence[str], selection: Selection, driver: Driver
) -> None:
    """Bring one case up to date and tell what happens."""
    with ExitStack() as open_things:

        def watch(run: Run, plan: Sequence, stages: Sequence) -> Any:
            print(f"{name}: {run.job.case.title}", flush=True)
            expected = expected_seconds(stages, run.history.seconds())
            return open_things.enter_context(Progress(name, stages, expected)).observe

        done = run_case(project, name, settings, selection, driver=driver, watch=watch)
    ended = (
        "nothing to do, all is fresh" if done.folder is None else f"done, {done.computed} computed"
    )
    print(f"{name}: {ended}")
    for page in History(project, name).latest().get("published", {}):
        print(f"  page  {near(project.root / page)}")
    print(f"  data  {near(project.runs / name / 'latest')}")


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
