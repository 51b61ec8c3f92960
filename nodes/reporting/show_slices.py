"""Slices in three planes with the labels over them."""

from nodes.geometry.grids import LabelMap, Volume
from nodes.reporting.artefacts import Section
from nodes.reporting.honesty import warnings_of
from nodes.reporting.parameters import ShowSlicesParameters
from nodes.reporting.slice_data import prepare_slices
from nodes.reporting.slice_section import SCRIPTS, render_slices


def show_slices(volume: Volume, label_map: LabelMap, parameters: ShowSlicesParameters) -> Section:
    """Show axial, coronal and sagittal slices with labels that can be hidden.

    Parameters
    ----------
    volume : values in HU or intensity.
    label_map : labels on the volume's own grid.
    parameters : size, windows, opacity of the labels.

    Returns
    -------
    A section that needs the scripts of the slice viewer.

    Raises
    ------
    BadInput where volume and labels lie on different grids.
    """
    data = prepare_slices(volume, label_map, parameters)
    html = render_slices(data, parameters)
    warnings = warnings_of(volume.origin, label_map.origin)
    return Section(parameters.title, html, warnings, SCRIPTS)
