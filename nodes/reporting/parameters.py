"""Parameters of the reporting stages."""

from typing import Annotated, Literal

from pydantic import Field

from nodes.parameters import Parameters

Share = Annotated[float, Field(ge=0, le=1)]
LevelAndWidth = tuple[float, Annotated[float, Field(gt=0)]]
Length = Annotated[float, Field(gt=0)]
Percent = Annotated[float, Field(ge=0, le=100)]


class ShowSurfacesParameters(Parameters):
    """Parameters of `show_surfaces`."""

    title: str
    """Heading of the section."""

    caption: str
    """A sentence below the heading; may be empty."""

    opacities: dict[str, Share]
    """Opacity at first of surfaces within which others lie, by name, 0 to 1 (no unit); 0 hides a
    surface until it is switched on; all others are opaque."""


class ShowSitesParameters(ShowSurfacesParameters):
    """Parameters of `show_sites`."""

    ball_radius_mm: Length
    """Radius of the ball at a named point in mm."""

    arrow_length_mm: Length
    """Length of the arrow along the +z axis of a named pose in mm."""

    arrow_radius_mm: Length
    """Radius of that arrow's shaft in mm."""


class ShowEntriesParameters(ShowSurfacesParameters):
    """Parameters of `show_entries`."""

    shown: tuple[str, ...]
    """Names of the surfaces that are shown with the entries, where they exist."""

    skin: tuple[str, ...]
    """Names of the surfaces on which the entry area is drawn."""

    skin_reach_mm: Length
    """Largest distance of a corner of the skin's surface from a voxel of the entry area, in mm."""

    area_opacity: Annotated[float, Field(gt=0, le=1)]
    """Opacity of the entry area at first, 0 to 1 (no unit)."""

    needle_radius_mm: Length
    """Radius of the needle drawn from skin to pleura in mm."""

    outside_mm: Annotated[float, Field(ge=0)]
    """Length of that needle that stands out of the skin in mm, so that it is seen."""

    clearance_limits_mm: tuple[float, float]
    """Bone clearances in mm at which the scale of colours begins and ends."""

    rows: Annotated[int, Field(ge=1, le=1000)]
    """Largest number of entries in the table, the first ones (no unit); the view has all."""

    decimals: Annotated[int, Field(ge=0, le=12)]
    """Digits after the decimal point of numbers in the table."""


class ShowShapeParameters(ShowSurfacesParameters):
    """Parameters of `show_shape`."""

    joint_radius_mm: Length
    """Radius of the ball where a snare grasps, in mm."""

    least_radius_share: Annotated[float, Field(ge=0, le=0.1)]
    """Least radius that is drawn, over the robot's extent (no unit): thinner tubes are all drawn
    thicker by one factor, and the page says by how much."""

    axis_length_mm: Length
    """Length of the arrow along the tip's tangent, in mm."""

    force_length_mm_per_n: Length
    """Length of the arrow of a force, mm per N."""

    decimals: Annotated[int, Field(ge=0, le=12)]
    """Digits after the decimal point of numbers in the table."""


class ShowRobotsParameters(ShowSurfacesParameters):
    """Parameters of all sections that show CRISP robots in a cavity."""

    shown: tuple[str, ...]
    """Names of the surfaces that are shown with the robots, where they exist."""

    pieces: Annotated[int, Field(ge=1, le=100)]
    """Into how many straight pieces each snare and each part of the camera tube before a grasp is
    drawn (no unit)."""

    least_radius_share: Annotated[float, Field(ge=0, le=0.1)]
    """Least radius of a needle that is drawn, over the extent of what is in the picture (no unit):
    thinner ones are all drawn thicker by one factor, and the page says by how much."""

    outside_mm: Length
    """Length of the sheaths that are drawn outside of the cavity, from the entry points, in mm."""

    cone_mm: Length
    """Length of the camera's cone as it is drawn, in mm."""

    cone_opacity: Annotated[float, Field(gt=0, le=1)]
    """Opacity of the camera's cone at first, 0 to 1 (no unit)."""

    decimals: Annotated[int, Field(ge=0, le=12)]
    """Digits after the decimal point of numbers in the tables."""


class ShowSetupsParameters(ShowRobotsParameters):
    """Parameters of `show_setups`."""

    left_out: tuple[Annotated[str, Field(min_length=1)], ...]
    """Endings of the names of set-ups that are not shown, such as those of a study that differ in
    how their trees were grown alone."""

    rows: Annotated[int, Field(ge=1, le=1000)]
    """Largest number of candidates in the table, the first ones (no unit)."""


class ShowCavityParameters(ShowRobotsParameters):
    """Parameters of the sections that show the surface of the free space."""

    cell_mm: Length
    """Size of the cells from which that surface is drawn, in mm."""

    smoothing_mm: Annotated[float, Field(ge=0)]
    """Standard deviation of the Gauss filter that smooths the surface, in mm."""

    cavity_opacity: Annotated[float, Field(gt=0, le=1)]
    """Opacity of that surface at first, 0 to 1 (no unit)."""


class ShowPlansParameters(ShowCavityParameters):
    """Parameters of `show_plans`."""

    most_motions: Annotated[int, Field(ge=1, le=100)]
    """Largest number of motions that are drawn, the first ones (no unit); the table has all."""

    most_steps: Annotated[int, Field(ge=2, le=10000)]
    """Largest number of steps of a motion that are drawn, evenly chosen (no unit)."""

    goal_radius_mm: Length
    """Radius of the ball at a goal, in mm."""

    way_radius_mm: Length
    """Radius of the line along which the camera moves, in mm."""

    pictures: Annotated[int, Field(ge=2, le=200)]
    """Number of camera pictures along each motion (no unit)."""

    pixels: Annotated[int, Field(ge=16, le=1024)]
    """Height and width of a camera picture in pixels."""

    quality: Annotated[int, Field(ge=1, le=100)]
    """Quality of the lossy WebP pictures (Pillow's scale, no unit)."""

    near_mm: Length
    """Depth at which a surface that faces the camera is half as bright as one that touches it, in
    mm."""

    tissue_mm: Length
    """Largest distance of the wall that is seen from an organ's surface for it to have the organ's
    colour, in mm."""


class ShowVisibilityParameters(ShowCavityParameters):
    """Parameters of `show_visibility`."""

    left_out: tuple[Annotated[str, Field(min_length=1)], ...]
    """Endings of the names of set-ups that are not shown, such as those of a study that are there
    to be compared; then the union is of the shown ones."""

    times: Annotated[int, Field(ge=2, le=20)]
    """Into how many spans of time the colours of "first seen" are cut (no unit)."""

    neighbours: Annotated[int, Field(ge=1, le=100)]
    """How many cells next to a place on the drawn surface vote for its colour (no unit); shares
    are counted cell by cell."""

    curve_points: Annotated[int, Field(ge=10, le=1000)]
    """Points of each curve over time (no unit)."""


class ShowStudyParameters(Parameters):
    """Parameters of `show_study`."""

    title: str
    """Heading of the section."""

    caption: str
    """A sentence below the heading; may be empty."""

    paper_share_percent: tuple[Percent, ...]
    """Share of the surface that the paper's set-ups saw, and last their union, in %; [Kuntz2017]
    Sec. V-A."""

    paper_unseeded_share_percent: tuple[Percent, ...]
    """The same without the neighbour's solution as seed, without union, in %; [Kuntz2017]
    Sec. V-C."""

    paper_nodes: tuple[Annotated[int, Field(ge=0)], ...]
    """Nodes of the paper's trees (no unit); [Kuntz2017] Sec. V-C."""

    paper_unseeded_nodes: tuple[Annotated[int, Field(ge=0)], ...]
    """Nodes of the paper's trees without that seed (no unit); [Kuntz2017] Sec. V-C."""

    paper_cores: Annotated[int, Field(ge=1)]
    """Cores of the paper's processor (no unit); [Kuntz2017] Sec. V."""

    paper_cells: Annotated[int, Field(ge=1)]
    """Cells of the paper's surface, about (no unit); [Kuntz2017] Sec. V-B."""

    paper_hours: Length
    """Hours for which the paper's trees grew; [Kuntz2017] Sec. V-A."""

    curve_points: Annotated[int, Field(ge=10, le=1000)]
    """Points of each curve over time (no unit)."""

    decimals: Annotated[int, Field(ge=0, le=12)]
    """Digits after the decimal point of numbers in the tables."""


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
    """Digits after the decimal point of numbers that have no unit and are not whole."""

    unit_decimals: Annotated[int, Field(ge=0, le=12)]
    """Digits after the decimal point of numbers that have a unit and are not whole."""


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

    first_warnings: Annotated[int, Field(ge=1, le=1000)]
    """Warnings of one kind that are shown at once; the others open with a click (no unit)."""

    hash_characters: Annotated[int, Field(ge=6, le=64)]
    """Characters of a hash that are shown; hovering and copying give all of them."""
