"""What the imaging stages pass on besides volumes and label maps."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Shaped

from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.grids import Volume


@dataclass(frozen=True)
class Slice:
    """One plane of an image series, as its DICOM file has it, without any identifier.

    Parameters
    ----------
    pixels : (rows, columns) in `unit`, rescale slope and intercept applied; int16 or float32.
    patient_from_pixel : (4, 4) maps (column, row, 0, 1) to patient LPS mm; its third column is the
        unit normal of the plane (DICOM PS3.3 C.7.6.2.1.1).
    series : number of the series within the folder, from 1, in order of first appearance.
    modality : DICOM modality, "CT", "MR", "OT", ...
    unit : "HU" for CT with rescale values, else "intensity".
    series_key : hash of the series instance UID (see series_key.py); "" where there never was one.
    kind : what sets the plane apart from others at its place, in words: image type, echo time,
        b-value, moment; "" where nothing is known.
    acquisition : number of the acquisition within the series, 0 where none is given.
    """

    pixels: Shaped[np.ndarray, "rows columns"]
    patient_from_pixel: Float[np.ndarray, "4 4"]
    series: int
    modality: str
    unit: str
    series_key: str = ""
    kind: str = ""
    acquisition: int = 0

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class ImageFiles:
    """What a person's image files hold: the planes of DICOM series, or one ready volume.

    Parameters
    ----------
    slices : planes in the order of their files' names; empty for a volume file.
    volume : the volume of a NIfTI, NRRD or MHA file, else None.
    skipped : number of files that hold no image plane.
    simulated : True where the files were written by a phantom.
    """

    slices: tuple[Slice, ...]
    volume: Volume | None = None
    skipped: int = 0
    simulated: bool = False
