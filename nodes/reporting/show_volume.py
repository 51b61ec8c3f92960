"""Slices of a volume in three planes."""

from nodes.geometry.grids import Volume
from nodes.reporting.artefacts import Section
from nodes.reporting.honesty import warnings_of
from nodes.reporting.parameters import ShowVolumeParameters
from nodes.reporting.slice_data import prepare_volume
from nodes.reporting.slice_section import SCRIPTS, render_slices


def show_volume(volume: Volume, parameters: ShowVolumeParameters) -> Section:
    """Show axial, coronal and sagittal slices of a volume without labels.

    Parameters
    ----------
    volume : values in HU or intensity.
    parameters : size and windows.

    Returns
    -------
    A section that needs the scripts of the slice viewer.
    """
    html = render_slices(prepare_volume(volume, parameters), parameters)
    return Section(parameters.title, html, warnings_of(volume.origin), SCRIPTS)
