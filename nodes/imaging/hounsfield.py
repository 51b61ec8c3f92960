"""When the values of a CT are Hounsfield units, and what is odd about them."""

from dataclasses import replace

import numpy as np

from nodes.errors import BadInput
from nodes.geometry.grids import Volume
from nodes.imaging.parameters import ReadVolumeParameters

# Highest value of an 8-bit picture.
_EIGHT_BIT = 255


def settle_unit(volume: Volume, is_file: bool, parameters: ReadVolumeParameters) -> Volume:
    """Return a CT in HU where that is known, else as intensities with a notice that says why.

    A volume file does not name its unit; a CT shows air, which is far below 0 HU. Of a DICOM
    series the files say it; yet if nothing in them is below 0, an offset was forgotten.

    Parameters
    ----------
    volume : unit "HU" where its files say so, else "intensity".
    is_file : whether it comes from a volume file.
    """
    if volume.unit != "HU" and parameters.modality != "CT":
        return volume
    lowest, highest = float(volume.voxels.min()), float(volume.voxels.max())
    known = lowest < 0 if volume.unit == "HU" else is_file and lowest <= parameters.air_hu
    if parameters.hu_offset is not None:
        return _with_offset(volume, known, parameters.hu_offset)
    if known and volume.unit == "HU":
        return volume
    if known:
        notice = "the volume file does not name its unit; HU are assumed"
        return replace(volume, unit="HU", origin=volume.origin.with_notice(notice))
    notice = f"values from {lowest:g} to {highest:g} {_doubt(lowest, highest, parameters)}"
    return replace(volume, unit="intensity", origin=volume.origin.with_notice(notice))


def _doubt(lowest: float, highest: float, parameters: ReadVolumeParameters) -> str:
    if lowest >= 0 and highest <= _EIGHT_BIT:
        return (
            "are those of an 8-bit picture and not HU, so they are read as intensities;"
            " no offset can mend that, export the scan again with all its values"
        )
    return (
        f"are not known to be HU (no air at or below {parameters.air_hu:g}, or no scale in the"
        " files), so they are read as intensities; if they are HU but for an offset, set the"
        " parameter hu_offset (0 if they are HU as they stand, often -1024 if the lowest is 0)"
    )


def _with_offset(volume: Volume, known: bool, offset: int) -> Volume:
    """Add the person's offset; refuse one for values that are HU already."""
    if known and offset:
        raise BadInput(
            f"hu_offset {offset} for values from {volume.voxels.min():g}, which are HU already",
            "an offset is for CT values of which the lowest, air, is 0 or more",
            "set hu_offset to null",
        )
    values = volume.voxels
    if values.dtype == np.int16:
        limits = np.iinfo(np.int16)
        shifted = np.clip(values.astype(np.int32) + offset, limits.min, limits.max)
    else:
        shifted = values + offset
    origin = volume.origin
    if not known:
        origin = origin.with_notice(f"values became HU by the parameter hu_offset ({offset:+d})")
    return replace(volume, voxels=shifted.astype(values.dtype), unit="HU", origin=origin)


def note_extremes(volume: Volume, parameters: ReadVolumeParameters) -> Volume:
    """Raise values below air to the lowest HU, and count them and those of metal."""
    voxels, notices = volume.voxels, []
    below = int(np.count_nonzero(voxels < parameters.lowest_hu))
    if below:
        voxels = np.maximum(voxels, voxels.dtype.type(parameters.lowest_hu))
        lowest = f"{parameters.lowest_hu:g} HU"
        notices.append(f"{below} voxels below {lowest} were set to it (padding or metal)")
    above = int(np.count_nonzero(voxels > parameters.metal_hu))
    if above:
        notices.append(
            f"{above} voxels above {parameters.metal_hu:g} HU (metal) were kept; streaks around"
            " metal spoil thresholds"
        )
    return replace(volume, voxels=voxels, origin=volume.origin.with_notice(*notices))
