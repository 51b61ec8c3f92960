"""A CT seen along the patient's own axes: +x left, +y posterior, +z superior, as far as voxels go.

However a scanner or a converter stored a scan, the segmentation works on the same array, so that
the same places in the patient get the same labels.
"""

from itertools import permutations, product
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from nodes.geometry.grids import Volume, spacing_mm, voxel_volume_mm3

ML_IN_MM3 = 1000.0
Mask = Bool[np.ndarray, "x y z"]
Box = tuple[slice, slice, slice]


class CtScan(NamedTuple):
    """A CT along the patient's axes, and where no region may grow.

    Parameters
    ----------
    hu : (x, y, z) values in HU.
    patient_from_index : (4, 4) indices of `hu` to patient LPS mm.
    closed : (x, y, z) the person's barriers.
    """

    hu: Shaped[np.ndarray, "x y z"]
    patient_from_index: Float[np.ndarray, "4 4"]
    closed: Mask

    @property
    def spacing(self) -> Float[np.ndarray, "3"]:
        """Distance of voxels, mm."""
        return spacing_mm(self.patient_from_index)

    def millilitres(self, voxels: float | int) -> float:
        """Return the volume of that many voxels, ml."""
        return float(voxels) * voxel_volume_mm3(self.patient_from_index) / ML_IN_MM3

    def voxels(self, millilitres: float) -> float:
        """Return how many voxels fill that volume."""
        return millilitres / self.millilitres(1)


class Turn(NamedTuple):
    """How an array's axes lie in the patient: which to take for x, y, z, and which to flip."""

    axes: tuple[int, ...]
    flipped: tuple[bool, ...]

    def forth(self, voxels: Shaped[np.ndarray, "_ _ _"]) -> Shaped[np.ndarray, "x y z"]:
        """Return the array along x, y, z of the patient."""
        return np.ascontiguousarray(voxels.transpose(self.axes)[self._flips()])

    def back(self, voxels: Shaped[np.ndarray, "x y z"]) -> Shaped[np.ndarray, "_ _ _"]:
        """Return the array along its own axes again."""
        return np.ascontiguousarray(voxels[self._flips()].transpose(np.argsort(self.axes)))

    def _flips(self) -> Box:
        x, y, z = (slice(None, None, -1 if flip else 1) for flip in self.flipped)
        return (x, y, z)


def turn_of(patient_from_index: Float[np.ndarray, "4 4"]) -> Turn:
    """Return the order and direction of index axes that come closest to x, y and z."""
    cosines = patient_from_index[:3, :3] / spacing_mm(patient_from_index)
    axes = max(permutations(range(3)), key=lambda p: sum(abs(cosines[n, p[n]]) for n in range(3)))
    return Turn(axes, tuple(bool(cosines[n, axes[n]] < 0) for n in range(3)))


def turned_transform(volume: Volume, turn: Turn) -> Float[np.ndarray, "4 4"]:
    """Return the turned array's indices to patient LPS mm."""
    own_from_turned = np.zeros((4, 4))
    own_from_turned[3, 3] = 1
    for place, (axis, flip) in enumerate(zip(turn.axes, turn.flipped, strict=True)):
        own_from_turned[axis, place] = -1 if flip else 1
        own_from_turned[axis, 3] = volume.voxels.shape[axis] - 1 if flip else 0
    return volume.patient_from_index @ own_from_turned


def points_of(
    shape: tuple[int, ...], patient_from_index: Float[np.ndarray, "4 4"], box: Box
) -> list[Float[np.ndarray, "_ _ _"]]:
    """Return x, y and z in patient LPS mm of the voxels in a box."""
    ranges = [np.arange(n)[side] for n, side in zip(shape, box, strict=True)]
    grid = np.meshgrid(*ranges, indexing="ij", sparse=True)
    return [
        row[0] * grid[0] + row[1] * grid[1] + row[2] * grid[2] + row[3]
        for row in patient_from_index[:3]
    ]


def box_around(
    shape: tuple[int, ...],
    patient_from_index: Float[np.ndarray, "4 4"],
    low_patient_mm: Float[np.ndarray, "3"],
    high_patient_mm: Float[np.ndarray, "3"],
) -> Box:
    """Return the part of the grid that holds a box in the patient; empty where it lies outside."""
    corners = np.array(list(product(*zip(low_patient_mm, high_patient_mm, strict=True))))
    index_from_patient = np.linalg.inv(patient_from_index)
    indices = corners @ index_from_patient[:3, :3].T + index_from_patient[:3, 3]
    first = np.clip(np.floor(indices.min(axis=0)), 0, shape).astype(int)
    last = np.clip(np.ceil(indices.max(axis=0)) + 1, 0, shape).astype(int)
    x, y, z = (slice(int(a), int(b)) for a, b in zip(first, last, strict=True))
    return (x, y, z)


def nearest_index(
    patient_from_index: Float[np.ndarray, "4 4"], points_patient_mm: Float[np.ndarray, "n 3"]
) -> Int[np.ndarray, "n 3"]:
    """Return the indices of the voxels nearest to points in the patient; they may lie outside."""
    index_from_patient = np.linalg.inv(patient_from_index)
    indices = points_patient_mm @ index_from_patient[:3, :3].T + index_from_patient[:3, 3]
    return np.rint(indices).astype(int)
