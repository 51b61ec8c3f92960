"""Label maps as a person hands them in, each on a grid of its own."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from nodes.geometry.grids import LabelMap

Triple = tuple[int, int, int]


@dataclass(frozen=True)
class FileLabels:
    """The labels of one file, or of one layer of it, cut to the box that holds them.

    Parameters
    ----------
    content : the labels and their names; no label is without a voxel.
    corner : indices of the first voxel of `content` within the file's grid.
    grid_shape : number of voxels of the file's grid along i, j and k.
    """

    content: LabelMap
    corner: Triple
    grid_shape: Triple

    @property
    def patient_from_grid(self) -> Float[np.ndarray, "4 4"]:
        """Return the (4, 4) map from voxel indices of the file's grid to patient LPS mm."""
        matrix = self.content.patient_from_index.copy()
        matrix[:3, 3] -= matrix[:3, :3] @ np.array(self.corner)
        return matrix


@dataclass(frozen=True)
class LabelFiles:
    """What a person's label map files hold.

    Parameters
    ----------
    maps : in the order of the files' names; empty where a person hands in none. No two labels share
        a name.
    skipped : number of files in the folder that are no label maps.
    """

    maps: tuple[FileLabels, ...] = ()
    skipped: int = 0
