"""Images on regular voxel grids in the patient frame: volumes of values and maps of labels.

Voxels are indexed `[i, j, k]`, and `patient_from_index @ (i, j, k, 1)` is the centre of that voxel
in the patient frame (LPS, mm): the index order of the formula is the index order of the array.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Shaped, UInt8

from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.origin import Origin


@dataclass(frozen=True)
class Volume:
    """Scalar values on a grid.

    Parameters
    ----------
    voxels : (i, j, k) int16 or float32, in `unit`.
    patient_from_index : (4, 4) voxel indices to patient LPS mm.
    unit : "HU" for CT, "intensity" for MRI, "mm" for distances.
    origin : source, what is simulated, notices.
    """

    voxels: Shaped[np.ndarray, "i j k"]
    patient_from_index: Float[np.ndarray, "4 4"]
    unit: str
    origin: Origin

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class LabelMap:
    """A name for every voxel of a grid.

    Parameters
    ----------
    voxels : (i, j, k) uint8 labels; 0 is background.
    patient_from_index : (4, 4) voxel indices to patient LPS mm.
    names : name of label n + 1 at place n.
    origin : source, what is simulated, notices.
    """

    voxels: UInt8[np.ndarray, "i j k"]
    patient_from_index: Float[np.ndarray, "4 4"]
    names: tuple[str, ...]
    origin: Origin

    def __post_init__(self) -> None:
        freeze_arrays(self)

    def mask(self, name: str) -> Bool[np.ndarray, "i j k"]:
        """Return where the label `name` is; raises ValueError for a name that is not there."""
        return self.voxels == self.names.index(name) + 1


def spacing_mm(patient_from_index: Float[np.ndarray, "4 4"]) -> Float[np.ndarray, "3"]:
    """Return the distance in mm between voxel centres along i, j and k."""
    return np.linalg.norm(patient_from_index[:3, :3], axis=0)


def voxel_volume_mm3(patient_from_index: Float[np.ndarray, "4 4"]) -> float:
    """Return the volume of one voxel in mm^3."""
    return float(abs(np.linalg.det(patient_from_index[:3, :3])))
