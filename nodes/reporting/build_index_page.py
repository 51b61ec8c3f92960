"""The page that lists all cases."""

from nodes.reporting.artefacts import CaseLine, Page
from nodes.reporting.honesty import gather_warnings
from nodes.reporting.rendering import render_template
from nodes.reporting.security import content_policy, safe_link


def build_index_page(*, cases: tuple[CaseLine, ...]) -> Page:
    """Build the page that lists all cases, each with its status, time, warnings and link.

    Parameters
    ----------
    cases : in the order of the page.

    Returns
    -------
    One HTML document without scripts.
    """
    lines = [
        {"case": case, "link": safe_link(case.page), "warnings": gather_warnings((case.warnings,))}
        for case in cases
    ]
    values = {"title": "All cases", "lines": lines, "policy": content_policy(())}
    return Page(render_template("index_page.html", values))
