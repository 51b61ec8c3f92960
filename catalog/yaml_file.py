"""YAML as people write it, with errors that name the file and the line."""

from pathlib import Path
from typing import Any

import yaml

from nodes.errors import BadInput


class _Loader(yaml.CSafeLoader if hasattr(yaml, "CSafeLoader") else yaml.SafeLoader):  # type: ignore[misc]
    """The safe loader, but a key written twice is an error and not the last one's win."""


def _mapping_once(loader: _Loader, node: yaml.MappingNode) -> dict:
    keys = [loader.construct_object(key) for key, _ in node.value]
    for place, key in enumerate(keys):
        if key in keys[:place]:
            raise yaml.MarkedYAMLError(
                problem=f"the key {key!r} stands twice",
                problem_mark=node.value[place][0].start_mark,
            )
    return loader.construct_mapping(node, deep=True)


_Loader.add_constructor("tag:yaml.org,2002:map", _mapping_once)


def load_mapping(path: Path) -> dict[str, Any]:
    """Return the mapping that a YAML file holds; an empty file is an empty mapping.

    Raises
    ------
    BadInput : if the file is missing, is no YAML, or holds something else.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BadInput(
            f"{path.name}: {error.strerror}", "the file must be there and readable", f"see {path}"
        ) from error
    return parse_mapping(content, path.name, f"open {path}")


def parse_mapping(content: bytes, name: str, way: str) -> dict[str, Any]:
    """Return the mapping that YAML text holds; no text is an empty mapping.

    Parameters
    ----------
    content : UTF-8 text.
    name : what errors call it, such as a file's name.
    way : how a person gets to it, such as "open robot.yml".

    Raises
    ------
    BadInput : if it is no YAML, or holds something else.
    """
    try:
        value = yaml.load(content.decode("utf-8"), _Loader)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise _bad_yaml(name, way, error) from error
    if value is not None and not isinstance(value, dict):
        raise BadInput(
            f"{name} holds a {type(value).__name__}",
            "the file must hold lines `key: value`",
            f"{way} and write keys",
        )
    return value or {}


def load_value(text: str) -> Any:
    """Return what a value means in YAML, as after `--set key=`; plain text where it is no YAML."""
    try:
        return "" if not text else yaml.load(text, _Loader)
    except yaml.YAMLError:
        return text


def value_text(value: Any) -> str:
    """Return a value as a person would write it after `key:`, on one line."""
    text = yaml.safe_dump(value, default_flow_style=True, width=float("inf"), allow_unicode=True)
    return text.removesuffix("...\n").strip()


def _bad_yaml(name: str, way: str, error: Exception) -> BadInput:
    mark = getattr(error, "problem_mark", None)
    where = f"{name}, line {mark.line + 1}" if mark else name
    problem = getattr(error, "problem", None) or str(error)
    return BadInput(f"{where}: {problem}", "the file must be YAML", f"{way} and mend it")
