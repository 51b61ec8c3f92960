"""Scripts, styles and templates of the pages: the one place where a node reads files.

They are part of the source, and the freshness key counts them as such.
"""

from importlib.resources import files


def read_asset(name: str) -> str:
    """Return the text of the file `name` in nodes/reporting/assets."""
    return files("nodes.reporting").joinpath("assets", name).read_text(encoding="utf-8")
