"""Parameters of the reporting stages."""

from typing import Annotated, Literal

from pydantic import Field

from nodes.parameters import Parameters

Share = Annotated[float, Field(ge=0, le=1)]
LevelAndWidth = tuple[float, Annotated[float, Field(gt=0)]]
Percent = Annotated[float, Field(ge=0, le=100)]


class ShowSurfacesParameters(Parameters):
    """Parameters of `show_surfaces`."""

    title: str
    """Heading of the section."""

    caption: str
    """A sentence below the heading; may be empty."""

    translucent: tuple[str, ...]
    """Names of the surfaces that are shown translucent, since others lie within them."""

    translucent_opacity: Share
    """Opacity of the translucent surfaces at first, 0 to 1 (no unit)."""


class ShowVolumeParameters(Parameters):
    """Parameters of `show_volume`."""

    title: str
    """Heading of the section."""

    caption: str
    """A sentence below the heading; may be empty."""

    pixels: Annotated[int, Field(ge=16, le=512)]
    """Largest number of voxels along each side of the shown volume."""

    quality: Annotated[int, Field(ge=1, le=100)]
    """Quality of the lossy WebP image that holds the slices (Pillow's scale, no unit)."""

    hu_knots: Annotated[tuple[float, ...], Field(min_length=2)]
    """Ascending HU at the knots of the curve from HU to the 8-bit grey that is sent."""

    grey_knots: Annotated[tuple[Annotated[float, Field(ge=0, le=255)], ...], Field(min_length=2)]
    """Ascending 8-bit grey at those knots; where it climbs steeply, contrast is kept."""

    soft_tissue_window_hu: LevelAndWidth
    """Level and width of the soft tissue window in HU."""

    lung_window_hu: LevelAndWidth
    """Level and width of the lung window in HU."""

    bone_window_hu: LevelAndWidth
    """Level and width of the bone window in HU."""

    window: Literal["soft tissue", "lung", "bone"]
    """Window at first of a volume in HU: soft tissue, lung or bone."""

    intensity_percentiles: tuple[Percent, Percent]
    """Percentiles of the voxels at which the first window of an MRI begins and ends, in %."""


class ShowSlicesParameters(ShowVolumeParameters):
    """Parameters of `show_slices`."""

    label_opacity: Share
    """Opacity of the label overlay at first, 0 to 1 (no unit)."""

    hidden_labels: tuple[str, ...]
    """Names of the labels that are switched off at first."""


class ShowTableParameters(Parameters):
    """Parameters of `show_table`."""

    title: str
    """Heading of the section."""

    caption: str
    """A sentence below the heading; may be empty."""

    decimals: Annotated[int, Field(ge=0, le=12)]
    """Digits after the decimal point of numbers that are not whole."""


class ShowFramesParameters(Parameters):
    """Parameters of `show_frames`."""

    title: str
    """Heading of the section."""

    most_frames: Annotated[int, Field(ge=1, le=1000)]
    """Largest number of frames that are shown, evenly chosen (no unit)."""

    width: Annotated[int, Field(ge=32, le=4096)]
    """Longer side of a shown frame in pixels."""

    quality: Annotated[int, Field(ge=1, le=100)]
    """Quality of the lossy WebP pictures (Pillow's scale, no unit)."""


class BuildCasePageParameters(Parameters):
    """Parameters of `build_case_page`."""

    hash_characters: Annotated[int, Field(ge=6, le=64)]
    """Characters of a hash that are shown; hovering and copying give all of them."""
