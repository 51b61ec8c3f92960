"""The command line, `tendril`."""

import os
import signal
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any

import click

from nodes.errors import BadInput
from pipelines.completion import complete_cases, complete_pipelines, complete_stages
from pipelines.inputs_command import InputsCommand
from pipelines.project import Project

STOPPED = 130
SOMETHING_STALE = 5

_EPILOG = """\b
Exit codes:
  0  done, or nothing to do
  1  a stage failed
  2  the command was misspelt
  3  a case, a parameter or an input was refused
  4  the disk kept nothing (full, read-only), or the store is in use
  5  `status --check` found something stale
  6  `shape` found no shape to build on
  130  stopped with Ctrl-C; the next run goes on from there
"""


@click.group(epilog=_EPILOG, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="tendril")
def main() -> None:
    """From a patient's images to a checked plan for a needle-sized robot.

    Research software, not a medical device.
    """
    signal.signal(signal.SIGTERM, _stop)


def _stop(number: int, frame: Any) -> None:
    raise KeyboardInterrupt


_case = click.option(
    "--case", "cases", multiple=True, metavar="NAME", shell_complete=complete_cases,
    help="This case only; may be given again. Default: all whose inputs are on this machine.",
)  # fmt: skip
_settings = click.option(
    "--set", "settings", multiple=True, metavar="KEY=VALUE",
    help="A parameter for this run: `key=value`, or `stage.key=value`.",
)  # fmt: skip
_pipeline = click.argument("pipeline", default="", shell_complete=complete_pipelines)


def _stage_option(flag: str, name: str, text: str, **more: Any) -> Any:
    return click.option(
        flag, name, default=() if more else "", metavar="STAGE", help=text,
        shell_complete=complete_stages, **more,
    )  # fmt: skip


@main.command()
@_pipeline
@_case
@_stage_option("--from", "first", "From this stage on.")
@_stage_option("--to", "last", "Up to this stage.")
@_stage_option("--only", "only", "This stage alone, its inputs from the cache.")
@_stage_option("--force", "forced", "Compute this stage even if it is fresh.", multiple=True)
@_settings
@click.option("--no-prefect", is_flag=True, help="Run in plain Python, without a Prefect flow.")
def run(
    pipeline: str,
    cases: Sequence[str],
    first: str,
    last: str,
    only: str,
    forced: tuple[str, ...],
    settings: Sequence[str],
    no_prefect: bool,
) -> None:
    """Bring cases up to date; what is fresh comes from the cache.

    \b
    Examples:
      tendril run                            every case on this machine
      tendril run --case thorax_phantom
      tendril run anatomy --set bone_threshold_hu=250
      tendril run --case thorax_phantom --only build_surfaces --force build_surfaces
    """
    from pipelines.console import prefect_driver, run_one, survive, tell_absent
    from pipelines.running import run_plainly, runnable_cases
    from pipelines.selection import Selection

    project = Project()
    selection = Selection(first, last, only, forced)
    names = runnable_cases(project, pipeline, cases)
    if not cases:
        tell_absent(project, pipeline, names)
    if not names:
        raise BadInput("no case to run", "a run needs a case with its inputs", "see `tendril list`")
    with ExitStack() as open_things:
        driver = run_plainly if no_prefect else prefect_driver(project, open_things)
        codes = [
            survive(lambda name=name: run_one(project, name, settings, selection, driver))
            for name in names
        ]
    sys.exit(next(filter(None, codes), 0))


@main.command()
@_pipeline
@_case
@_settings
@click.option("--check", is_flag=True, help="Exit with 5 if any stage is not fresh.")
@click.option("--verify", is_flag=True, help="Read every byte again instead of file times.")
def status(
    pipeline: str, cases: Sequence[str], settings: Sequence[str], check: bool, verify: bool
) -> None:
    """Tell of each stage whether it is fresh, stale and why, or never ran."""
    from pipelines.console import survive, tell_absent, tell_status
    from pipelines.outcomes import FRESH
    from pipelines.running import runnable_cases

    project = Project()
    names = runnable_cases(project, pipeline, cases)
    if not cases:
        tell_absent(project, pipeline, names)
    states: list[str] = []
    codes = [
        survive(lambda name=name: states.extend(tell_status(project, name, settings, verify)))
        for name in names
    ]
    stale = check and set(states) != {FRESH}
    sys.exit(next(filter(None, codes), SOMETHING_STALE if stale else 0))


@main.command("list")
@click.argument(
    "what", default="", type=click.Choice(["", "pipelines", "stages", "datasets", "cases"]),
    metavar="[pipelines|stages|datasets|cases]",
)  # fmt: skip
def list_command(what: str) -> None:
    """List pipelines, stages, datasets and cases."""
    from pipelines.listing import LISTS

    for name in [what] if what else LISTS:
        print(f"{name}:")
        for line in LISTS[name](Project()):
            print(f"  {line}")


@main.command("new-case", cls=InputsCommand)
@click.argument("name")
def new_case(name: str, title: str | None, pipeline: str | None, **inputs: str | None) -> None:
    """Write a commented case file for your own images.

    \b
    Example:
      tendril new-case phantom_2 --ct /data/phantom_2
    """
    from pipelines.new_case import write_case

    project = Project()
    given = {dataset: path for dataset, path in inputs.items() if path}
    path = write_case(project, name, given, title or "", pipeline or "")
    print(f"wrote {os.path.relpath(path)}\nnext: tendril run --case {name}")


@main.command()
@click.argument("robot", type=click.Path(), metavar="ROBOT.yml")
@click.argument("configuration", type=click.Path(), metavar="CONFIG.yml")
@click.option("--name", default="shape", show_default=True, help="Name of its page and data.")
@_settings
def shape(robot: str, configuration: str, name: str, settings: Sequence[str]) -> None:
    """Compute the shape of a robot in one configuration, and a page that shows it.

    \b
    Example:
      tendril shape robot.yml configuration.yml    catalog/robots/ has examples
    """
    from pipelines.shape_command import compute_shape

    sys.exit(compute_shape(Project(), robot, configuration, name, settings))


@main.command()
@click.argument("case", default="", shell_complete=complete_cases)
@click.option("--open", "show", is_flag=True, help="Open it in the browser.")
def report(case: str, show: bool) -> None:
    """Print where a case's page is, or that of all cases; open it with --open."""
    project = Project()
    if case:
        project.case(case)
    page = project.root / "reports" / f"{case or 'index'}.html"
    if not page.exists():
        raise BadInput(
            f"no page {os.path.relpath(page)}",
            "a page is made by a run",
            f"tendril run{f' --case {case}' if case else ''}",
        )
    print(os.path.relpath(page))
    if show:
        click.launch(page.as_uri())


@main.command()
def serve() -> None:
    """Run the schedules of prefect.yaml on this machine, until Ctrl-C."""
    from pipelines.server import prefect_server

    project = Project()
    with prefect_server(project.data, schedules=True) as address:
        from pipelines.flows import serve_schedules

        print(f"serving the schedules of prefect.yaml; Prefect answers at {address}", flush=True)
        serve_schedules(project)


@main.command()
@click.option(
    "--keep",
    type=click.IntRange(min=1),
    default=1,
    show_default=True,
    metavar="N",
    help="Runs to keep of each case.",
)
@click.option("--dry-run", is_flag=True, help="Only tell what would go.")
def clean(keep: int, dry_run: bool) -> None:
    """Drop artefacts that no kept run uses.

    Kept are the newest N runs of each case, and its newest complete one.
    """
    from pipelines.cleaning import clean_store

    runs, artefacts, size = clean_store(Project(), keep, dry_run=dry_run)
    verb = "would drop" if dry_run else "dropped"
    print(f"{verb} {runs} runs, {artefacts} artefacts, {size / 1e6:.1f} MB")


@main.command()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def completion(shell: str) -> None:
    """Print the lines that teach a shell to complete tendril's words.

    \b
    Example:
      tendril completion bash >> ~/.bashrc
    """
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    assert kind is not None  # the choices above are click's own
    print(kind(main, {}, "tendril", "_TENDRIL_COMPLETE").source())


def entry() -> None:
    """Run the command line with exit codes that scripts can use."""
    from pipelines.console import survive

    try:
        sys.exit(survive(_command))
    except KeyboardInterrupt:
        message = "stopped; what is finished is kept, and the next run goes on from there"
        print(message, file=sys.stderr)
        sys.exit(STOPPED)


def _command() -> None:
    """Run click; what it refuses it shows itself."""
    try:
        code = main.main(standalone_mode=False)
    except click.ClickException as error:
        error.show()
        code = error.exit_code
    except click.Abort:
        raise KeyboardInterrupt from None
    sys.exit(code if isinstance(code, int) else 0)


if __name__ == "__main__":
    entry()
