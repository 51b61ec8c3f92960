"""Writing a commented case file for a person's own images."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import yaml

from catalog.cases import check_case_name
from nodes.errors import BadInput
from pipelines.history import publish
from pipelines.index import publish_index
from pipelines.project import Project, find_pipeline
from pipelines.registry import PIPELINES
from pipelines.stage import Stage

_HEAD = """\
# One case: where its images are, and what differs from the defaults.
# Run it with:  tendril run --case {name}
"""
_PARAMETERS = """
# What differs from the defaults, stage by stage; take out the # before what you change.
# Unknown names are refused. Meaning, unit and source of each stand in catalog/parameters/.
parameters:
"""


def write_case(
    project: Project, name: str, inputs: Mapping[str, str], title: str = "", pipeline: str = ""
) -> Path:
    """Write catalog/cases/<name>.yml and return its path.

    Raises
    ------
    BadInput : if the name is bad or taken, an input is not there, or no pipeline takes these.
    """
    check_case_name(name)
    path = project.cases_folder / f"{name}.yml"
    if path.exists():
        raise BadInput(
            f"case {name}", "a case is never overwritten", f"choose another name than {path.name}"
        )
    absolute = {dataset: _existing(dataset, written) for dataset, written in inputs.items()}
    chosen = pipeline or _find_pipeline(project, set(inputs))
    wanted = _wanted(project, find_pipeline(chosen))
    if wanted != set(inputs):
        raise BadInput(
            f"inputs {', '.join(sorted(inputs)) or 'none'}",
            f"pipeline {chosen} takes {', '.join(sorted(wanted)) or 'none'}",
            "give just these, or leave --pipeline out",
        )
    head = {"title": title or name, "pipeline": chosen, "inputs": absolute}
    text = _HEAD.format(name=name) + yaml.safe_dump(head, sort_keys=False, allow_unicode=True)
    text += _PARAMETERS + "".join(_defaults(project, s) for s in find_pipeline(chosen))
    publish(path, text.encode("utf-8"))
    publish_index(project)
    return path


def _existing(dataset: str, written: str) -> str:
    path = Path(written).expanduser().resolve()
    if not path.exists():
        raise BadInput(f"{dataset}: {written}", "an input must exist", "mend the path")
    return str(path)


def _find_pipeline(project: Project, given: set[str]) -> str:
    """Return the one pipeline whose inputs are those given."""
    fitting = [name for name, p in PIPELINES.items() if _wanted(project, p.STAGES) == given]
    if len(fitting) == 1 and given:
        return fitting[0]
    options = ", ".join(d.option for d in project.catalog.values() if d.option)
    raise BadInput(
        f"inputs {', '.join(sorted(given)) or 'none'}",
        f"{'several pipelines take' if fitting and given else 'no pipeline takes'} just these",
        f"give one of {options}" + (f", and --pipeline {' or '.join(fitting)}" if fitting else ""),
    )


def _wanted(project: Project, stages: Sequence[Stage]) -> set[str]:
    made = {name for stage in stages for name in stage.outputs}
    return {n for stage in stages for n in stage.inputs if project.catalog[n].is_input} - made


def _defaults(project: Project, stage: Stage) -> str:
    """Return a stage's default parameters, commented out, with their own comments."""
    path = project.root / "catalog" / "parameters" / f"{stage.name}.yml"
    if not path.exists():
        return ""
    lines = [line for line in path.read_text("utf-8").splitlines() if line.strip()]
    return f"#  {stage.name}:\n" + "".join(f"#    {line}\n" for line in lines)
