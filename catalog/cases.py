"""Cases: one patient or phantom each, with its inputs and what differs from the defaults."""

import os
import re
from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from catalog.validation import unknown, validate
from catalog.yaml_file import load_mapping
from nodes.errors import BadInput

_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")


class Case(BaseModel):
    """What catalog/cases/<name>.yml says."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    title: str = Field(description="heading of the case's page; never a patient's name")
    pipeline: str = Field(description="name of a pipeline, see `tendril list`")
    inputs: dict[str, str] = Field(
        default={}, description="dataset -> file or folder, absolute or below data/raw"
    )
    on_request: bool = Field(
        default=False, description="true for a long case that runs only where it is asked for"
    )
    parameters: dict[str, dict[str, Any]] = Field(
        default={}, description="stage -> parameter -> value, only what differs from the default"
    )


def list_cases(folder: Path) -> list[str]:
    """Return the names of all cases."""
    return sorted(path.stem for path in folder.glob("*.yml"))


def load_case(folder: Path, name: str) -> Case:
    """Return a case by its name.

    Raises
    ------
    BadInput : if there is no such case, or its file breaks a rule.
    """
    if name not in list_cases(folder):
        raise unknown("case", name, list_cases(folder))
    check_case_name(name)
    path = folder / f"{name}.yml"
    values = {key: value or {} if key in ("inputs", "parameters") else value
              for key, value in load_mapping(path).items()}  # fmt: skip
    if "name" in values:
        raise BadInput(f"{path.name}: name", "a case is named by its file", "take the line out")
    return validate(Case, {"name": name, **values}, path.name)


def check_case_name(name: str) -> None:
    """Refuse what can't be a case's name; it becomes part of file names and links."""
    if not _NAME.fullmatch(name) or name == "index":
        raise BadInput(
            f"case name {name!r}",
            "1 to 64 letters a-z, digits, - and _, a letter or digit first, and not `index`",
            "choose a name such as phantom_2 (and never a patient's)",
        )


def resolve_input(written: str, raw: Path, variables: Mapping[str, Path]) -> Path:
    """Return the path that a case means: `${NAME}/...`, absolute, or below data/raw.

    Raises
    ------
    BadInput : for a relative path that climbs out with `..`, or a variable that is not known.
    """
    path = re.sub(r"\$\{(\w+)\}", lambda match: _variable(match[1], variables), written)
    if ".." in PurePath(path).parts:
        raise BadInput(
            f"input {written}",
            "a case's path must not climb with `..`",
            "write the absolute path, or put the data below data/raw",
        )
    return raw / path


def _variable(name: str, variables: Mapping[str, Path]) -> str:
    value = os.environ.get(name) or variables.get(name)
    if not value:
        raise BadInput(f"variable {name}", "a variable in a path must be set", f"export {name}=...")
    # A variable is set by whoever runs the program, and may be relative to where that is done.
    return os.path.abspath(value)
