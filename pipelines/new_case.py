"""Writing a commented case file for a person's own images."""

from collections.abc import Mapping
from pathlib import Path

import yaml

from catalog.cases import check_case_name
from nodes.errors import BadInput
from pipelines.history import publish
from pipelines.index import publish_index
from pipelines.project import Project, find_pipeline, wanted_inputs
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
    chosen = pipeline or _fitting_pipelines(project, inputs)[0]
    wanted = wanted_inputs(project.catalog, find_pipeline(chosen))
    if not _fits(wanted, inputs):
        takes = [f"{name} (optional)" if more else name for name, more in wanted.items()]
        raise BadInput(
            f"inputs {', '.join(sorted(inputs)) or 'none'}",
            f"pipeline {chosen} takes {', '.join(takes) or 'none'}",
            "give just these, or leave --pipeline out",
        )
    head = {"title": title or name, "pipeline": chosen, "inputs": absolute}
    text = _HEAD.format(name=name) + _others(project, inputs, chosen)
    text += yaml.safe_dump(head, sort_keys=False, allow_unicode=True)
    text += "".join(_optional(project, n) for n in wanted if n not in inputs)
    text += _PARAMETERS + "".join(_defaults(project, s) for s in find_pipeline(chosen))
    publish(path, text.encode("utf-8"))
    publish_index(project)
    return path


def _existing(dataset: str, written: str) -> str:
    path = Path(written).expanduser().resolve()
    if not path.exists():
        raise BadInput(f"{dataset}: {written}", "an input must exist", "mend the path")
    return str(path)


def _fitting_pipelines(project: Project, given: Mapping[str, str]) -> list[str]:
    """Return the pipelines that can do with the inputs given, in the order of the registry."""
    catalog = project.catalog
    fitting = [
        name
        for name, module in PIPELINES.items()
        if _fits(wanted_inputs(catalog, module.STAGES), given)
    ]
    if fitting and given:
        return fitting
    options = ", ".join(d.option for d in catalog.values() if d.option)
    raise BadInput(
        f"inputs {', '.join(sorted(given)) or 'none'}",
        "no pipeline takes just these",
        f"give one of {options}",
    )


def _others(project: Project, given: Mapping[str, str], chosen: str) -> str:
    names = [name for name in _fitting_pipelines(project, given) if name != chosen]
    return f"# Pipelines that take these inputs, too: {', '.join(names)}\n" if names else ""


def _optional(project: Project, name: str) -> str:
    """Return a line for an input that may be added, commented out; it ends the list of inputs."""
    return f"#  {name}: <file or folder>   # {project.catalog[name].about}\n"


def _fits(wanted: Mapping[str, bool], given: Mapping[str, str]) -> bool:
    """Return whether all that is needed is given, and nothing that is unknown."""
    needed = {name for name, optional in wanted.items() if not optional}
    return needed <= given.keys() <= wanted.keys()


def _defaults(project: Project, stage: Stage) -> str:
    """Return a stage's default parameters, commented out, with their own comments."""
    path = project.root / "catalog" / "parameters" / f"{stage.name}.yml"
    if not path.exists():
        return ""
    lines = [line for line in path.read_text("utf-8").splitlines() if line.strip()]
    return f"#  {stage.name}:\n" + "".join(f"#    {line}\n" for line in lines)
