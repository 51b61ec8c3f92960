"""Images brought to cubic voxels along the patient's axes.

On such a grid neither the scanner's orientation nor its spacing matters to what follows.
"""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Float32, Shaped

from nodes.geometry.grids import Volume, spacing_mm

if TYPE_CHECKING:
    import SimpleITK

Affine = Float[np.ndarray, "4 4"]
Voxels = Float32[np.ndarray, "i j k"]

FINER = 0.95  # steps that are finer than this share of the new ones are smoothed
ROUNDING = 1e-3  # of a voxel, by which an extent may pass the last one


def to_working_grid(volume: Volume, voxel_size_mm: float, outside: float) -> tuple[Voxels, Affine]:
    """Resample a whole volume to cubic voxels along x, y and z, linear between voxel centres.

    Axes with finer steps are smoothed first, so that noise is averaged and not picked. Outside of
    the volume is the value `outside`.

    Returns
    -------
    voxels : (i, j, k) along the patient's left, posterior and superior.
    patient_from_index : diagonal but for its last column, patient LPS mm.
    """
    import SimpleITK as sitk

    low, high = _extent(volume)
    counts = np.ceil((high - low) / voxel_size_mm - ROUNDING).astype(int) + 1
    patient_from_index = np.diag([voxel_size_mm, voxel_size_mm, voxel_size_mm, 1.0])
    patient_from_index[:3, 3] = (low + high - (counts - 1) * voxel_size_mm) / 2
    image = to_itk(volume.voxels.astype(np.float32), volume.patient_from_index)
    for axis, step in enumerate(spacing_mm(volume.patient_from_index)):
        if step < FINER * voxel_size_mm:
            sigma = float(np.sqrt(voxel_size_mm**2 - step**2)) / 2
            image = sitk.RecursiveGaussian(image, sigma, False, 0, axis)
    shape = tuple(counts.tolist())
    return _resampled(image, patient_from_index, shape, outside), patient_from_index


def _extent(volume: Volume) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """Return the lowest and highest x, y and z of all voxel centres."""
    corners = np.array(list(np.ndindex(2, 2, 2))) * (np.array(volume.voxels.shape) - 1)
    matrix = volume.patient_from_index
    places = corners @ matrix[:3, :3].T + matrix[:3, 3]
    return places.min(axis=0), places.max(axis=0)


def to_itk(voxels: Shaped[np.ndarray, "i j k"], patient_from_index: Affine) -> "SimpleITK.Image":
    """Return an ITK image whose x, y and z are i, j and k."""
    import SimpleITK as sitk

    image = sitk.GetImageFromArray(np.ascontiguousarray(voxels.T))
    spacing = spacing_mm(patient_from_index)
    image.SetSpacing(spacing.tolist())
    image.SetDirection((patient_from_index[:3, :3] / spacing).ravel().tolist())
    image.SetOrigin(patient_from_index[:3, 3].tolist())
    return image


def _resampled(
    image: "SimpleITK.Image",
    patient_from_index: Affine,
    shape: tuple[int, ...],
    outside: float,
) -> Float32[np.ndarray, "a b c"]:
    import SimpleITK as sitk

    spacing = spacing_mm(patient_from_index)
    moved = sitk.Resample(
        image,
        shape,
        sitk.Transform(),
        sitk.sitkLinear,
        patient_from_index[:3, 3].tolist(),
        spacing.tolist(),
        (patient_from_index[:3, :3] / spacing).ravel().tolist(),
        outside,
        sitk.sitkFloat32,
    )
    return np.ascontiguousarray(sitk.GetArrayViewFromImage(moved).T)
