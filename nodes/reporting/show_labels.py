"""Labels in three planes where there is no image below them."""

import numpy as np

from nodes.geometry.grids import LabelMap, Volume
from nodes.reporting.artefacts import Section
from nodes.reporting.parameters import ShowSlicesParameters
from nodes.reporting.show_slices import show_slices


def show_labels(label_map: LabelMap, parameters: ShowSlicesParameters) -> Section:
    """Show axial, coronal and sagittal slices of labels on black.

    Parameters
    ----------
    label_map : labels of an anatomy without an image.
    parameters : size, opacity of the labels; its windows mean nothing here.

    Returns
    -------
    A section that needs the script "slices".
    """
    black = np.zeros(label_map.voxels.shape, np.int16)
    origin = label_map.origin.with_notice("no image was given: the slices show labels alone")
    return show_slices(
        Volume(black, label_map.patient_from_index, "intensity", origin), label_map, parameters
    )
