"""Templates filled with values: every text is escaped unless it is a finished fragment."""

from collections.abc import Mapping

from nodes.reporting.assets import read_asset


def render_template(name: str, values: Mapping[str, object]) -> str:
    """Return the template `name` filled with `values`; a missing value is an error."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    environment = Environment(
        loader=FunctionLoader(read_asset),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["seconds"] = format_seconds
    environment.filters["moment"] = format_moment
    return environment.get_template(name).render(values)


def format_seconds(seconds: float) -> str:
    """Return a duration as people read it, with three digits at most."""
    if seconds < 0.0995:
        return f"{seconds * 1000:.0f} ms"
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    if seconds < 99.5:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{seconds / 3600:.1f} h"


def format_moment(text: str) -> str:
    """Return "2025-01-03 14:02:11 UTC" for "2025-01-03T14:02:11Z", and other text unchanged."""
    from re import sub

    return sub(r"^(\d{4}-\d\d-\d\d)T(\d\d:\d\d:\d\d)(\.\d+)?Z$", r"\1 \2 UTC", text)
