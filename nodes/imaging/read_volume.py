"""From the planes of image files to one volume."""

from dataclasses import replace

import numpy as np

from nodes.errors import BadInput
from nodes.geometry.grids import Volume, spacing_mm
from nodes.imaging.artefacts import ImageFiles, Slice
from nodes.imaging.hounsfield import note_extremes, settle_unit
from nodes.imaging.parameters import ReadVolumeParameters
from nodes.imaging.series import choose_series, split_series
from nodes.imaging.stacking import Positions, make_regular, stack_planes, too_few


def read_volume(image_files: ImageFiles, parameters: ReadVolumeParameters) -> Volume:
    """Choose a series, stack its planes by their positions, and settle what its values mean.

    A leaning stack (gantry tilt) is straightened. A volume file passes through the same checks.

    Parameters
    ----------
    image_files : planes or one volume.
    parameters : wanted series, tolerances of the stack, what counts as HU.

    Returns
    -------
    The volume in HU or "intensity", with notices of what was chosen, skipped, resampled, clipped.

    Raises
    ------
    BadInput where no series is of the modality, none is clearly the wanted one, or the chosen one
    is not one even stack of planes.
    """
    is_file = image_files.volume is not None
    if is_file:
        volume, positions = _read_file(image_files.volume, parameters)
    else:
        volume, positions = _read_series(image_files.slices, parameters)
    _refuse_impossible(volume, parameters)
    origin = volume.origin
    if image_files.skipped:
        notice = f"files without an image plane were skipped: {image_files.skipped}"
        origin = origin.with_notice(notice)
    origin = replace(origin, simulated=image_files.simulated or origin.simulated)
    volume = settle_unit(replace(volume, origin=origin), is_file, parameters)
    volume = make_regular(volume, positions, parameters)
    return note_extremes(volume, parameters) if volume.unit == "HU" else volume


def _read_series(
    slices: tuple[Slice, ...], parameters: ReadVolumeParameters
) -> tuple[Volume, Positions]:
    planes, notices = choose_series(split_series(slices, parameters), parameters)
    volume, positions = stack_planes(planes, parameters)
    return replace(volume, origin=volume.origin.with_notice(*notices)), positions


def _read_file(volume: Volume, parameters: ReadVolumeParameters) -> tuple[Volume, Positions]:
    """Return a volume file's voxels and where its planes lie; its third axis may lean."""
    fewest = min(volume.voxels.shape)
    if fewest < parameters.fewest_planes:
        raise too_few(fewest, parameters.fewest_planes)
    axes = volume.patient_from_index[:3, :3] / spacing_mm(volume.patient_from_index)
    skew_deg = 90 - float(np.rad2deg(np.arccos(np.clip(abs(axes[:, 0] @ axes[:, 1]), 0, 1))))
    if skew_deg > parameters.tilt_tolerance_deg:
        raise BadInput(
            f"rows and columns meet at {90 - skew_deg:.1f} deg",
            f"they are at right angles, within {parameters.tilt_tolerance_deg:g} deg",
            "resample the volume onto a straight grid, for instance in 3D Slicer",
        )
    number = np.arange(volume.voxels.shape[2])
    first, step = volume.patient_from_index[:3, 3], volume.patient_from_index[:3, 2]
    return volume, first + np.outer(number, step)


def _refuse_impossible(volume: Volume, parameters: ReadVolumeParameters) -> None:
    """Refuse sizes that no scan has, and values that are no numbers."""
    spacing = spacing_mm(volume.patient_from_index)
    extent = spacing * volume.voxels.shape
    low, high = parameters.smallest_spacing_mm, parameters.largest_extent_mm
    if not (spacing.min() >= low and extent.max() <= high):
        raise BadInput(
            f"voxels from {spacing.min():.3g} mm, sides up to {extent.max():.3g} mm",
            f"edges are {low:g} mm or more and sides {high:g} mm or less",
            "mend the spacing in the file's header; its unit must be mm",
        )
    strange = volume.voxels.size - int(np.count_nonzero(np.isfinite(volume.voxels)))
    if strange:
        raise BadInput(
            f"{strange} voxels are not a number or infinite",
            "every voxel must have a value",
            "replace them, for instance by -1024 HU outside the scan",
        )
