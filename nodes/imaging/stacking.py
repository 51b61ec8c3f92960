"""From the planes of one series to voxels on a straight, even grid."""

import numpy as np
from jaxtyping import Float, Shaped

from nodes.errors import BadInput
from nodes.geometry.grids import Volume
from nodes.geometry.origin import Origin
from nodes.imaging.artefacts import Slice
from nodes.imaging.parameters import ReadVolumeParameters
from nodes.imaging.straightening import PlaneStack, even_out, straighten

Positions = Float[np.ndarray, "k 3"]


def stack_planes(
    planes: tuple[Slice, ...], parameters: ReadVolumeParameters
) -> tuple[Volume, Positions]:
    """Sort the planes by place; return their values, and where each plane's first pixel lies.

    The order of files and instance numbers means nothing; the positions along the normal do. The
    grid of the volume is that of the first plane and the mean step, so it may lean.

    Raises
    ------
    BadInput where the planes are too few or unlike.
    """
    if len(planes) < parameters.fewest_planes:
        raise too_few(len(planes), parameters.fewest_planes)
    if len({plane.unit for plane in planes}) > 1:
        raise _not_a_stack("planes in HU and planes without", "all planes have one unit")
    ordered = _sorted_by_place(planes)
    positions = np.stack([plane.patient_from_pixel[:3, 3] for plane in ordered])
    course = positions[-1] - positions[0]
    if course @ ordered[0].patient_from_pixel[:3, 2] <= parameters.position_tolerance_mm:
        raise _not_a_stack(f"{len(planes)} planes at one place", "planes of a volume lie apart")
    patient_from_index = ordered[0].patient_from_pixel.copy()
    patient_from_index[:3, 2] = course / (len(positions) - 1)
    origin = Origin(f"DICOM {planes[0].modality} series of {len(planes)} planes")
    return Volume(_voxels(ordered), patient_from_index, planes[0].unit, origin), positions


def make_regular(volume: Volume, positions: Positions, parameters: ReadVolumeParameters) -> Volume:
    """Return the volume on a straight, even grid; a leaning or uneven one is resampled.

    Parameters
    ----------
    volume : planes [i, j, k] with rows and columns at right angles.
    positions : (k, 3) first pixel of each plane, patient LPS mm.

    Raises
    ------
    BadInput for what must not be resampled.
    """
    stack, origin = _plane_stack(volume, positions), volume.origin
    even = is_even(stack, parameters)
    _refuse_crooked(stack, parameters)
    if not even:  # along the way of the table, before what lies outside the scan comes in
        stack = even_out(stack, _tolerance_mm(stack, parameters))
        origin = origin.with_notice(_tell_steps(positions, stack))
    tilt_deg = stack.tilt_deg()
    leans = tilt_deg > parameters.tilt_tolerance_deg
    if leans:
        outside = parameters.lowest_hu if volume.unit == "HU" else float(volume.voxels.min())
        stack = straighten(stack, outside)
        origin = origin.with_notice(_tell_tilt(tilt_deg, outside, volume.unit))
    if even and not leans:
        return volume
    return Volume(stack.voxels, stack.patient_from_index(), volume.unit, origin)


def _plane_stack(volume: Volume, positions: Positions) -> PlaneStack:
    """Return the planes with their normal, which points from the first to the last."""
    axes = volume.patient_from_index[:3, :3].copy()
    normal = np.cross(axes[:, 0], axes[:, 1])
    axes[:, 2] = normal / np.linalg.norm(normal) * np.sign(normal @ axes[:, 2] or 1.0)
    return PlaneStack(volume.voxels, axes, positions)


def _tell_steps(positions: Positions, even: PlaneStack) -> str:
    steps = np.diff(positions @ even.axes[:, 2])
    heights = even.heights()
    return (
        f"planes lay {steps.min():.2f} to {steps.max():.2f} mm apart: they were interpolated to"
        f" steps of {heights[1] - heights[0]:.2f} mm; what is between them is an estimate"
    )


def _tell_tilt(tilt_deg: float, outside: float, unit: str) -> str:
    return (
        f"the stack leaned by {tilt_deg:.1f} deg (gantry tilt): its planes were shifted straight"
        " above each other, with linear interpolation; what lies outside the scan was set to"
        f" {outside:g}" + (" HU" if unit == "HU" else "")
    )


def is_even(stack: PlaneStack, parameters: ReadVolumeParameters) -> bool:
    """Return whether the steps are even; refuse doubled planes and gaps that must stay."""
    heights = stack.heights()
    steps, tolerance = np.diff(heights), _tolerance_mm(stack, parameters)
    even = np.linspace(heights[0], heights[-1], len(heights))
    if steps.min() <= tolerance:
        place = _place(heights, int(steps.argmin()))
        raise _not_a_stack(f"two planes at one place, {place}", "each plane is there once")
    if abs(heights - even).max() <= tolerance:
        return True
    widest = float(steps.max())
    fill = parameters.uneven_spacing == "resample"
    if fill and widest <= parameters.largest_gap_mm:
        return False
    wrong = f"{widest:.2f} mm {_place(heights, int(steps.argmax()))}, elsewhere {steps.min():.2f}"
    raise BadInput(
        f"distances between planes from {steps.min():.2f} to {widest:.2f} mm: {wrong} mm",
        f"planes lie evenly, each within {tolerance:.3g} mm of its place, and none is missing"
        + (f"; gaps up to {parameters.largest_gap_mm:g} mm may be filled" if fill else ""),
        "export the whole series again, or set uneven_spacing: resample to fill gaps up to"
        " largest_gap_mm by interpolation",
    )


def _tolerance_mm(stack: PlaneStack, parameters: ReadVolumeParameters) -> float:
    """Return how far a plane may lie off its place, mm.

    A plane that is missing in the middle moves its neighbours half a step off an even stack, so
    it is never more than a quarter of a step.
    """
    return min(parameters.position_tolerance_mm, float(np.diff(stack.heights()).mean()) / 4)


def _place(heights: Float[np.ndarray, "n"], below: int) -> str:
    """Return between which planes a step lies, counted along the normal from 1."""
    low, high = heights[below], heights[below + 1]
    return (
        f"between planes {below + 1} and {below + 2} of {len(heights)}"
        f" (at {low:.1f} and {high:.1f} mm along their normal)"
    )


def _refuse_crooked(stack: PlaneStack, parameters: ReadVolumeParameters) -> None:
    """Refuse a stack that leans too much or whose planes are shifted sideways."""
    tilt_deg = stack.tilt_deg()
    if tilt_deg > parameters.largest_tilt_deg:
        raise _not_a_stack(
            f"the stack leans by {tilt_deg:.1f} deg",
            f"a gantry tilts by {parameters.largest_tilt_deg:g} deg at most",
        )
    shift = stack.largest_sideways_shift_mm()
    if shift > parameters.position_tolerance_mm:
        raise _not_a_stack(
            f"planes shifted sideways by up to {shift:.2f} mm",
            f"each lies within {parameters.position_tolerance_mm:g} mm of its place",
        )


def too_few(planes: int, fewest: int) -> BadInput:
    """Return the error for what is no volume for lack of planes."""
    found = "one plane only" if planes == 1 else f"{planes} planes only"
    return _not_a_stack(found, f"a volume needs {fewest} planes or more")


def _not_a_stack(value: str, rule: str) -> BadInput:
    return BadInput(value, rule, "export one plain axial series of the scan, whole, and use that")


def _sorted_by_place(planes: tuple[Slice, ...]) -> list[Slice]:
    normal = planes[0].patient_from_pixel[:3, 2]
    return sorted(planes, key=lambda plane: float(plane.patient_from_pixel[:3, 3] @ normal))


def _voxels(planes: list[Slice]) -> Shaped[np.ndarray, "i j k"]:
    """Stack to [i, j, k] = [column, row, plane]; int16 where all planes are."""
    rows, columns = planes[0].pixels.shape
    kind = np.result_type(*{plane.pixels.dtype for plane in planes})
    voxels = np.empty((columns, rows, len(planes)), kind)
    for k, plane in enumerate(planes):
        voxels[:, :, k] = plane.pixels.T
    return voxels
