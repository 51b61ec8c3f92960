"""Surfaces that turn in a page."""

from nodes.geometry.meshes import Surfaces
from nodes.reporting.artefacts import Section
from nodes.reporting.honesty import warnings_of
from nodes.reporting.parameters import ShowSurfacesParameters
from nodes.reporting.scene import SCRIPTS, render_scene


def show_surfaces(surfaces: Surfaces, parameters: ShowSurfacesParameters) -> Section:
    """Show surfaces in a 3-D view that turns, zooms and hides parts.

    Parameters
    ----------
    surfaces : named surfaces, patient LPS mm; empty ones are named below the view.
    parameters : title, caption, opacities.

    Returns
    -------
    A section that needs the script of the 3-D viewer.
    """
    html = render_scene(surfaces, (), parameters)
    return Section(parameters.title, html, warnings_of(surfaces.origin), SCRIPTS)
