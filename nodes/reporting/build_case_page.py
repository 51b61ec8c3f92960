"""The page of one case."""

from nodes.reporting.artefacts import Page, RunAccount, Section
from nodes.reporting.embedding import share_buffers
from nodes.reporting.honesty import gather_warnings
from nodes.reporting.parameters import BuildCasePageParameters
from nodes.reporting.pipeline_picture import draw_pipeline
from nodes.reporting.rendering import render_template
from nodes.reporting.security import collect_scripts, content_policy

WIDE = {"columns": 5, "box_width": 178.0}
NARROW = {"columns": 1, "box_width": 176.0}
"""The same stages drawn for a screen and for a phone."""


def build_case_page(
    *sections: Section, run_account: RunAccount, parameters: BuildCasePageParameters
) -> Page:
    """Build the self-contained page of one case.

    Parameters
    ----------
    sections : in the order of the page.
    run_account : what was made, from what, with what.
    parameters : how many warnings are shown at once, and how hashes are shown.

    Returns
    -------
    One HTML document that needs no file and no network.
    """
    scripts = collect_scripts(sections)
    warnings = gather_warnings(tuple(section.warnings for section in sections))
    inputs = tuple(name for name, _, _ in run_account.inputs)
    titles = [section.title for section in sections]
    fragments = share_buffers(tuple(section.html for section in sections))
    pictures = [
        draw_pipeline(run_account.stages, inputs, **layout, name=name)
        for name, layout in (("wide", WIDE), ("narrow", NARROW))
    ]
    values = {
        "title": run_account.title,
        "account": run_account,
        "sections": list(zip(titles, fragments, strict=True)),
        "warnings": warnings,
        "first_warnings": parameters.first_warnings,
        "pictures": pictures if run_account.stages else [],
        "scripts": scripts,
        "policy": content_policy(scripts),
        "hash_characters": parameters.hash_characters,
    }
    return Page(render_template("case_page.html", values))
