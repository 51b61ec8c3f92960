"""Closed types for what people write: an unknown key is answered with the nearest known one."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from nodes.errors import BadInput

Model = TypeVar("Model", bound=BaseModel)


def validate(model: type[Model], values: Mapping[str, Any], where: str) -> Model:
    """Return the values as that type.

    Raises
    ------
    BadInput : for the first key that is unknown, missing, or has a value outside its rule.
    """
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise _explain(model, error, where) from error


def nearest(name: str, known: Iterable[str]) -> str:
    """Return "did you mean ...?", or the list of what is known where nothing is near."""
    known = sorted(known)
    close = get_close_matches(name, known, n=1, cutoff=0.5)
    return f"did you mean {close[0]}?" if close else f"known: {', '.join(known) or 'none'}"


def unknown(kind: str, name: str, known: Iterable[str]) -> BadInput:
    """Return the error for a name that does not exist."""
    known = list(known)
    return BadInput(
        f"no {kind} {name}", f"it must be one of {len(known)} names", nearest(name, known)
    )


def _explain(model: type[BaseModel], error: ValidationError, where: str) -> BadInput:
    first = error.errors(include_url=False)[0]
    key = ".".join(str(part) for part in first["loc"])
    fields = model.model_fields
    if first["type"] == "extra_forbidden":
        rule = "only keys that exist may be set; a misspelt one would be ignored in silence"
        return BadInput(f"{where}: unknown key {key}", rule, nearest(key, fields))
    name = str(first["loc"][0]) if first["loc"] else ""
    meaning = (fields[name].description or "") if name in fields else ""
    rule = f"{key}: {first['msg']}" + (f" ({meaning})" if meaning else "")
    if first["type"] == "missing":
        return BadInput(f"{where}: {key} is missing", rule, f"add a line `{key}: ...`")
    return BadInput(f"{where}: {key} = {first['input']!r}", rule, f"give {key} an allowed value")
