"""Wiring: pipelines as plain lists of stages, the engine, Prefect flows and the command line.

In Python and notebooks: `from pipelines import open_case`.
"""

from typing import TYPE_CHECKING

from pipelines.loading import load_from_source

load_from_source()

if TYPE_CHECKING:
    from pipelines.opened_case import OpenedCase


def open_case(name: str, *settings: str) -> "OpenedCase":
    """Open a case by its name, with `key=value` settings on top of its own parameters."""
    from pipelines.opened_case import OpenedCase
    from pipelines.project import Project

    return OpenedCase(Project(), name, settings)
