"""What the slice viewer reads: a grey mosaic, a label mosaic, and how to understand them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume, spacing_mm
from nodes.reporting.colours import colour_names, words
from nodes.reporting.embedding import encode_base64
from nodes.reporting.first_view import choose_first_slices
from nodes.reporting.mosaics import encode_png, encode_webp, lay_mosaic
from nodes.reporting.parameters import ShowSlicesParameters, ShowVolumeParameters
from nodes.reporting.slicing import (
    average_blocks,
    block_size,
    orient_to_patient,
    pick_blocks,
    reduced_transform,
    tilt_deg,
    to_grey,
)

LEAST_WIDTH = 1e-6
"""Width of the window of a volume whose voxels are all alike; any width shows it as it is."""


@dataclass(frozen=True)
class SliceData:
    """One volume for the slice viewer.

    Parameters
    ----------
    header : what the viewer must know, ready for JSON (its format: assets/README.md).
    grey : base64 of a WebP mosaic.
    labels : base64 of a PNG mosaic, or "".
    tilt_deg : largest angle in degrees between the shown planes and the patient's.
    """

    header: dict[str, object]
    grey: str
    labels: str
    tilt_deg: float


@dataclass(frozen=True)
class GreyScale:
    """How values become grey: the knots of the curve, and windows as (name, level, width)."""

    knots: tuple[float, ...]
    greys: tuple[float, ...]
    windows: tuple[tuple[str, float, float], ...]
    window: str


def prepare_volume(volume: Volume, parameters: ShowVolumeParameters) -> SliceData:
    """Return the volume in few 8-bit voxels along the patient's axes.

    Raises
    ------
    BadInput where the volume has no voxel.
    """
    if not volume.voxels.size:
        raise BadInput(
            f"a volume of {volume.voxels.shape} voxels",
            "a volume that is shown has at least one voxel along each side",
            "check the stage that made it",
        )
    voxels, patient_from_index = orient_to_patient(volume.voxels, volume.patient_from_index)
    block = block_size(voxels.shape, parameters.pixels)
    values = average_blocks(voxels, block)
    scale = choose_scale(values, volume.unit, parameters)
    picture, tiles = lay_mosaic(to_grey(values, scale.knots, scale.greys))
    shown = reduced_transform(patient_from_index, block)
    header = describe_grid(values.shape, shown, tiles) | describe_scale(scale, volume.unit)
    header |= {"block": list(block), "plain": bool(np.ptp(np.nan_to_num(values)) == 0)}
    grey = encode_base64(encode_webp(picture, parameters.quality))
    return SliceData(header, grey, "", tilt_deg(shown))


def prepare_slices(
    volume: Volume, label_map: LabelMap, parameters: ShowSlicesParameters
) -> SliceData:
    """Return volume and labels on one reduced grid.

    Raises
    ------
    BadInput where the two lie on different grids.
    """
    check_same_grid(volume, label_map)
    data = prepare_volume(volume, parameters)
    voxels, _ = orient_to_patient(label_map.voxels, label_map.patient_from_index)
    labels = pick_blocks(voxels, block_size(voxels.shape, parameters.pixels))
    step = 255 // max(1, int(labels.max()), len(label_map.names))
    picture, _ = lay_mosaic(labels * np.uint8(step))
    named = describe_labels(label_map.names, parameters)
    visible = tuple(n for n, label in enumerate(named, start=1) if label["visible"])
    first = choose_first_slices(labels, visible)
    header = data.header | {"labels": named, "label_step": step, "at": first}
    return SliceData(header, data.grey, encode_base64(encode_png(picture)), data.tilt_deg)


def check_same_grid(volume: Volume, label_map: LabelMap) -> None:
    """Raise BadInput unless voxel (i, j, k) is the same place in both."""
    same = volume.voxels.shape == label_map.voxels.shape and np.allclose(
        volume.patient_from_index, label_map.patient_from_index, rtol=0, atol=1e-3
    )
    if not same:
        raise BadInput(
            f"a volume of {volume.voxels.shape} and a label map of {label_map.voxels.shape} voxels",
            "slices need volume and labels on one grid: same size, same place within 0.001 mm",
            "resample the label map to the volume's grid first",
        )


def choose_scale(
    values: Float[np.ndarray, "i j k"], unit: str, parameters: ShowVolumeParameters
) -> GreyScale:
    """Return the clinical windows for HU, the range of the values for anything else."""
    if unit == "HU":
        windows = (
            ("soft tissue", *parameters.soft_tissue_window_hu),
            ("lung", *parameters.lung_window_hu),
            ("bone", *parameters.bone_window_hu),
        )
        return GreyScale(parameters.hu_knots, parameters.grey_knots, windows, parameters.window)
    return scale_of_intensities(values, parameters.intensity_percentiles)


def scale_of_intensities(
    values: Float[np.ndarray, "i j k"], percentiles: tuple[float, float]
) -> GreyScale:
    """Return a straight scale from least to greatest value, and windows for it."""
    finite = values[np.isfinite(values)]
    shown = finite if finite.size else np.array([0.0, 1.0])
    low, high = float(shown.min()), float(shown.max())
    start, end = map(float, np.percentile(shown, percentiles))
    name = f"{percentiles[0]:g}\u2013{percentiles[1]:g} %"
    windows = (window_between(name, start, end), window_between("min\u2013max", low, high))
    top = max(high, low + LEAST_WIDTH * max(1.0, abs(low)))
    return GreyScale((low, top), (0.0, 255.0), windows, name)


def window_between(name: str, low: float, high: float) -> tuple[str, float, float]:
    """Return the window (name, level, width) from one value to another."""
    return name, (low + high) / 2, max(high - low, LEAST_WIDTH)


def describe_grid(
    shape: tuple[int, ...], patient_from_index: Float[np.ndarray, "4 4"], tiles: dict[str, int]
) -> dict[str, object]:
    """Return the part of the header that says where the voxels are."""
    return {
        "format": "tendril-slices",
        "version": 1,
        "shape": list(shape),
        "spacing_mm": spacing_mm(patient_from_index).tolist(),
        "patient_from_index": patient_from_index.tolist(),
        "index_from_patient": np.linalg.inv(patient_from_index).tolist(),
        "at": [length // 2 for length in shape],
        "tiles": tiles,
        "labels": [],
        "label_step": 1,
    }


def describe_scale(scale: GreyScale, unit: str) -> dict[str, object]:
    """Return the part of the header that says what the greys mean."""
    names = ("name", "level", "width")
    return {
        "knots": list(scale.knots),
        "greys": list(scale.greys),
        "unit": unit,
        "windows": [dict(zip(names, window, strict=True)) for window in scale.windows],
        "window": scale.window,
    }


def describe_labels(
    names: tuple[str, ...], parameters: ShowSlicesParameters
) -> list[dict[str, object]]:
    """Return the part of the header that names the labels; label n + 1 stands at place n."""
    return [
        {
            "name": words(name),
            "colour": colour,
            "opacity": parameters.label_opacity,
            "visible": name not in parameters.hidden_labels,
        }
        for name, colour in zip(names, colour_names(names), strict=True)
    ]
