"""Masks brought from one voxel grid to any other, turned and anisotropic ones included."""

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, Real

from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import spacing_mm

if TYPE_CHECKING:
    import SimpleITK

Affine = Float[np.ndarray, "4 4"]
Box = tuple[slice, slice, slice]
# Where a voxel lies halfway between others, its share is 0.5 but for rounding. All points are moved
# by this part of a voxel, so that of two opposite faces one falls inside and the other outside.
TIE_SHIFT = 1e-4
# Steps that differ by less are the same step, written with few digits.
ROUNDING = 0.01
# Shares are kept for this many voxels at a time: they take 8 bytes each, the mask one.
SLAB_VOXELS = 20_000_000


@dataclass(frozen=True)
class Grid:
    """A voxel grid without values.

    Parameters
    ----------
    patient_from_index : (4, 4) voxel indices to patient LPS mm.
    shape : number of voxels along i, j and k.
    """

    patient_from_index: Affine
    shape: tuple[int, int, int]

    def __post_init__(self) -> None:
        freeze_arrays(self)

    def __str__(self) -> str:
        """Return the size of the voxels, for people."""
        return " x ".join(f"{step:.3g}" for step in spacing_mm(self.patient_from_index)) + " mm"


def same_lattice(a: Grid, b: Grid, tolerance_voxels: float) -> bool:
    """Return whether each voxel of `b` lies on one of `a`, or would if `a` went on.

    Where the outer corners do, all else does; a small turn or a wrong step shows most there.
    """
    corners = _corners(b)
    apart = transform_points(_a_from_b(a.patient_from_index, b.patient_from_index), corners)
    apart -= corners
    return bool(abs(apart - np.rint(apart[0])).max() <= tolerance_voxels)


def same_grid(a: Grid, b: Grid, tolerance_voxels: float) -> bool:
    """Return whether two grids have the same voxels, to a tolerance in voxels of `a`."""
    start = _a_from_b(a.patient_from_index, b.patient_from_index)[:3, 3]
    starts_alike = bool(abs(start).max() < 0.5)
    return a.shape == b.shape and starts_alike and same_lattice(a, b, tolerance_voxels)


def _corners(grid: Grid) -> Float[np.ndarray, "8 3"]:
    """Return the outer corners of the corner voxels, as indices."""
    return np.array(list(product(*[(-0.5, n - 0.5) for n in grid.shape])))


def index_extent(
    grid_from_patient: Affine, other: Grid
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """Return the lowest and highest index of a grid that any part of another grid's voxels has."""
    places = transform_points(grid_from_patient @ other.patient_from_index, _corners(other))
    return places.min(axis=0), places.max(axis=0)


def count_outside(mask: Bool[np.ndarray, "i j k"], patient_from_index: Affine, grid: Grid) -> int:
    """Return how many voxels of a mask have their centre outside of all voxels of a grid."""
    low, high = index_extent(
        np.linalg.inv(grid.patient_from_index), Grid(patient_from_index, mask.shape)
    )
    if (low >= -0.5 - ROUNDING).all() and (high <= np.array(grid.shape) - 0.5 + ROUNDING).all():
        return 0
    grid_from_mask = _a_from_b(grid.patient_from_index, patient_from_index)
    j, k = np.ogrid[: mask.shape[1], : mask.shape[2]]
    count = 0
    for i, plane in enumerate(mask):  # plane by plane: places take 8 bytes a voxel and axis
        outside = np.zeros(plane.shape, bool)
        for row, size in zip(grid_from_mask[:3], grid.shape, strict=True):
            place = row[0] * i + row[1] * j + row[2] * k + row[3]
            outside |= (place < -0.5) | (place >= size - 0.5)
        count += int(np.count_nonzero(plane & outside))
    return count


def regrid_mask(
    mask: Bool[np.ndarray, "i j k"],
    patient_from_index: Affine,
    grid: Grid,
    tolerance_voxels: float,
) -> tuple[Box, Bool[np.ndarray, "a b c"]]:
    """Bring a mask to another grid: a voxel is in it where at least half of the voxel is.

    The share is linear between the mask's voxel centres, and nothing lies beyond its array. Where
    the grid's voxels are larger, the share is the mean over evenly spaced points in the voxel, as
    many along each axis as voxels of the mask fit.

    Parameters
    ----------
    mask : of any extent; what surrounds it is empty.
    patient_from_index : of the mask.
    grid : where it goes.
    tolerance_voxels : voxels that lie this near to the grid's own are copied as they are.

    Returns
    -------
    box : the part of the grid that the mask reaches; empty where it lies beside the grid.
    inside : the mask in that box.
    """
    source = Grid(patient_from_index, mask.shape)
    low, high = index_extent(np.linalg.inv(grid.patient_from_index), source)
    if same_lattice(grid, source, tolerance_voxels):
        return _cropped(mask, np.rint(low + 0.5).astype(int), grid)
    start, stop = _clipped(np.floor(low), np.ceil(high) + 1, grid)
    inside = np.zeros(tuple(stop - start), bool)
    if inside.size:
        _sample(mask, _a_from_b(patient_from_index, grid.patient_from_index), start, inside)
    return _box(start, stop), inside


def _cropped(
    mask: Bool[np.ndarray, "i j k"], corner: Int[np.ndarray, "3"], grid: Grid
) -> tuple[Box, Bool[np.ndarray, "a b c"]]:
    """Return the part of a mask that lies in the grid, its first voxel at `corner` there."""
    start, stop = _clipped(corner, corner + mask.shape, grid)
    return _box(start, stop), mask[_box(start - corner, stop - corner)]


def _clipped(
    low: Real[np.ndarray, "3"], high: Real[np.ndarray, "3"], grid: Grid
) -> tuple[Int[np.ndarray, "3"], Int[np.ndarray, "3"]]:
    start = np.clip(low, 0, grid.shape).astype(int)
    return start, np.maximum(np.clip(high, 0, grid.shape).astype(int), start)


def _box(start: Int[np.ndarray, "3"], stop: Int[np.ndarray, "3"]) -> Box:
    i, j, k = (slice(int(a), int(b)) for a, b in zip(start, stop, strict=True))
    return i, j, k


def _a_from_b(patient_from_a: Affine, patient_from_b: Affine) -> Affine:
    return np.linalg.solve(patient_from_a, patient_from_b)


def _sample(
    mask: Bool[np.ndarray, "i j k"],
    mask_from_grid: Affine,
    start: Int[np.ndarray, "3"],
    inside: Bool[np.ndarray, "a b c"],
) -> None:
    """Write to `inside`, whose first voxel has the grid's indices `start`, where the mask is."""
    import SimpleITK as sitk

    image = sitk.GetImageFromArray(np.pad(mask, 1).view(np.uint8))
    offsets = _offsets(mask_from_grid)
    thickness = max(1, SLAB_VOXELS // inside[0].size)
    for low in range(0, len(inside), thickness):
        slab = inside[low : low + thickness]
        first = start + offsets + [low, 0, 0]
        places = transform_points(mask_from_grid, first) + 1 + TIE_SHIFT  # 1 for the padding
        share = sum(_shares(image, mask_from_grid, place, slab.shape) for place in places)
        slab[:] = share >= 0.5 * len(offsets)


def _offsets(mask_from_grid: Affine) -> Float[np.ndarray, "n 3"]:
    """Return points within a voxel of the grid, in its indices, from its centre."""
    fitting = np.ceil(abs(mask_from_grid[:3, :3]).max(axis=0) - ROUNDING)
    counts = np.maximum(fitting, 1).astype(int)
    return np.array(list(product(*[(np.arange(n) + 0.5) / n - 0.5 for n in counts])))


def _shares(
    image: "SimpleITK.Image",
    mask_from_grid: Affine,
    first: Float[np.ndarray, "3"],
    shape: tuple[int, int, int],
) -> Float32[np.ndarray, "a b c"]:
    """Return a mask, linear between its voxels, at the grid's points from index `first` on."""
    import SimpleITK as sitk

    transform = sitk.AffineTransform(3)  # between indices; ITK's x is the last axis of an array
    transform.SetMatrix(mask_from_grid[:3, :3][::-1, ::-1].ravel().tolist())
    transform.SetTranslation(first[::-1].tolist())
    resampled = sitk.Resample(
        image, shape[::-1], transform, sitk.sitkLinear,
        (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), np.eye(3).ravel().tolist(), 0.0, sitk.sitkFloat32,
    )  # fmt: skip
    return sitk.GetArrayFromImage(resampled)
