"""From the planes of image files to one volume."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.geometry.grids import Volume, spacing_mm
from nodes.geometry.origin import Origin
from nodes.imaging.artefacts import ImageFiles, Slice
from nodes.imaging.parameters import ReadVolumeParameters


def read_volume(image_files: ImageFiles, parameters: ReadVolumeParameters) -> Volume:
    """Choose the largest series of the wanted modality and stack its planes by their positions.

    The order of files and instance numbers means nothing; the positions along the normal do. A
    volume file passes through.

    Parameters
    ----------
    image_files : planes or one volume.
    parameters : wanted modality, tolerances of the stack.

    Returns
    -------
    The volume in HU or "intensity", with notices of what was chosen, skipped and clipped.

    Raises
    ------
    BadInput where no plane is of the modality, or the chosen series is not one even, straight
    stack of equal planes.
    """
    if image_files.volume is not None:
        _refuse_impossible(image_files.volume, parameters)
        volume = _with_unit(image_files.volume, parameters.modality)
    else:
        volume = _stack_largest_series(image_files.slices, parameters)
        _refuse_impossible(volume, parameters)
    if image_files.skipped:
        notice = f"{image_files.skipped} files hold no image plane and were skipped"
        volume = replace(volume, origin=volume.origin.with_notice(notice))
    simulated = image_files.simulated or volume.origin.simulated
    volume = replace(volume, origin=replace(volume.origin, simulated=simulated))
    return _clipped(volume, parameters.lowest_hu) if volume.unit == "HU" else volume


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


def _with_unit(volume: Volume, modality: str) -> Volume:
    """Take a volume file's values for HU if a CT is wanted and they can be HU.

    A volume file does not name its unit; a CT shows air, which is far below 0 HU.
    """
    if modality != "CT":
        return volume
    if volume.voxels.min() >= 0:
        notice = "no value is below 0, so the values are not HU and are read as intensities"
        return replace(volume, origin=volume.origin.with_notice(notice))
    origin = volume.origin.with_notice("the volume file does not name its unit; HU are assumed")
    return replace(volume, unit="HU", origin=origin)


def _stack_largest_series(slices: tuple[Slice, ...], parameters: ReadVolumeParameters) -> Volume:
    planes, notices = _largest_series(slices, parameters.modality)
    _refuse_unlike(planes, parameters.orientation_tolerance_deg)
    planes, positions = _sorted_by_position(planes)
    _refuse_uneven(positions, planes[0].patient_from_pixel[:3, 2], parameters)
    origin = Origin(f"DICOM {planes[0].modality} series of {len(planes)} planes", False, notices)
    return Volume(_voxels(planes), _patient_from_index(planes, positions), planes[0].unit, origin)


def _largest_series(
    slices: tuple[Slice, ...], modality: str
) -> tuple[list[Slice], tuple[str, ...]]:
    """Return the series with most pixels, the first of several, and a notice if it was a choice."""
    series: dict[int, list[Slice]] = {}
    for plane in slices:
        if modality in (plane.modality, "any"):
            series.setdefault(plane.series, []).append(plane)
    if not series:
        found = ", ".join(sorted({plane.modality for plane in slices})) or "none"
        raise BadInput(
            f"modalities found: {found}",
            f"a series of modality {modality} is wanted",
            "set the parameter modality to what there is, or name the folder with the series",
        )
    chosen = max(series, key=lambda number: sum(plane.pixels.size for plane in series[number]))
    count = len({plane.series for plane in slices})
    if count == 1:
        return series[chosen], ()
    notice = f"series {chosen} of {count} was chosen, the largest ({len(series[chosen])} planes)"
    return series[chosen], (notice,)


def _refuse_unlike(planes: list[Slice], tolerance_deg: float) -> None:
    """Refuse planes of different size, unit, spacing or direction."""
    if len(planes) < 2:
        raise _not_a_stack("one plane only", "a volume needs 2 planes or more")
    if len({(plane.pixels.shape, plane.unit) for plane in planes}) > 1:
        raise _not_a_stack("planes of several sizes or units", "all planes are alike")
    axes = np.stack([plane.patient_from_pixel[:3, :3] for plane in planes])
    lengths = np.linalg.norm(axes, axis=1)
    cosines = np.einsum("nij,ij->nj", axes / lengths[:, None], axes[0] / lengths[0])
    turn_deg = np.rad2deg(np.arccos(np.clip(cosines.min(), -1, 1)))
    if turn_deg > tolerance_deg:
        raise _not_a_stack(
            f"planes turned by up to {turn_deg:.2f} deg against each other",
            f"all planes have one orientation, within {tolerance_deg:g} deg",
        )
    if not np.allclose(lengths, lengths[0], rtol=1e-3):
        raise _not_a_stack("planes with several pixel spacings", "all planes are alike")


def _sorted_by_position(planes: list[Slice]) -> tuple[list[Slice], Float[np.ndarray, "n 3"]]:
    """Sort along the normal; return also the positions of the first pixels, patient LPS mm."""
    positions = np.stack([plane.patient_from_pixel[:3, 3] for plane in planes])
    order = np.argsort(positions @ planes[0].patient_from_pixel[:3, 2], kind="stable")
    return [planes[index] for index in order], positions[order]


def _refuse_uneven(
    positions: Float[np.ndarray, "n 3"],
    normal: Float[np.ndarray, "3"],
    parameters: ReadVolumeParameters,
) -> None:
    """Refuse doubled, missing, shifted and tilted planes."""
    heights = positions @ normal
    steps = np.diff(heights)
    tolerance = parameters.position_tolerance_mm
    even = np.linspace(heights[0], heights[-1], len(heights))
    if steps.min() <= tolerance or abs(heights - even).max() > tolerance:
        raise _not_a_stack(
            f"distances between planes from {steps.min():.2f} to {steps.max():.2f} mm",
            f"planes lie apart and evenly, each within {tolerance:g} mm of its place;"
            " none is missing or there twice",
        )
    _refuse_crooked(positions, normal, parameters)


def _refuse_crooked(
    positions: Float[np.ndarray, "n 3"],
    normal: Float[np.ndarray, "3"],
    parameters: ReadVolumeParameters,
) -> None:
    """Refuse a stack that leans (gantry tilt) or whose planes are shifted sideways."""
    course = positions[-1] - positions[0]
    cosine = course @ normal / np.linalg.norm(course)
    tilt_deg = np.rad2deg(np.arccos(np.clip(cosine, -1, 1)))
    if tilt_deg > parameters.tilt_tolerance_deg:
        raise BadInput(
            f"the stack leans by {tilt_deg:.1f} deg (gantry tilt)",
            f"planes lie straight above each other, within {parameters.tilt_tolerance_deg:g} deg",
            "resample the series to a straight one and use that",
        )
    even = np.linspace(positions[0], positions[-1], len(positions))
    shift = float(np.linalg.norm(positions - even, axis=1).max())
    if shift > parameters.position_tolerance_mm:
        raise _not_a_stack(
            f"planes shifted sideways by up to {shift:.2f} mm",
            f"each lies within {parameters.position_tolerance_mm:g} mm of its place",
        )


def _not_a_stack(value: str, rule: str) -> BadInput:
    return BadInput(value, rule, "export one plain axial series of the scan, whole, and use that")


def _patient_from_index(
    planes: list[Slice], positions: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "4 4"]:
    matrix = planes[0].patient_from_pixel.copy()
    matrix[:3, 2] = (positions[-1] - positions[0]) / (len(positions) - 1)
    return matrix


def _voxels(planes: list[Slice]) -> np.ndarray:
    """Stack to [i, j, k] = [column, row, plane]; int16 where all planes are."""
    rows, columns = planes[0].pixels.shape
    kind = np.result_type(*{plane.pixels.dtype for plane in planes})
    voxels = np.empty((columns, rows, len(planes)), kind)
    for k, plane in enumerate(planes):
        voxels[:, :, k] = plane.pixels.T
    return voxels


def _clipped(volume: Volume, lowest_hu: float) -> Volume:
    below = int(np.count_nonzero(volume.voxels < lowest_hu))
    if not below:
        return volume
    notice = f"{below} voxels below {lowest_hu:g} HU were set to it (padding or metal)"
    lowest = volume.voxels.dtype.type(lowest_hu)
    voxels = np.maximum(volume.voxels, lowest)
    return replace(volume, voxels=voxels, origin=volume.origin.with_notice(notice))
