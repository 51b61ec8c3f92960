"""Parameters of the environment stages; their values stand in catalog/parameters."""

from typing import Annotated, Literal

from pydantic import Field

from nodes.parameters import Parameters

Name = Annotated[str, Field(min_length=1)]
CellSize = Annotated[float, Field(ge=0.2, le=20)]
TriangleCount = Annotated[int, Field(ge=100, le=2_000_000)]


class BuildOccupancyGridParameters(Parameters):
    """Where the robot may move and how finely space is cut."""

    free_labels: Annotated[tuple[Name, ...], Field(min_length=1)]
    """Names of the labels whose inside together is free; everything else is obstacle."""
    apart: tuple[tuple[Name, Name], ...]
    """Pairs of labels that never communicate, as the two pleural sacs: where both are free and
    touch, the cells between them are a wall. Pairs that are not both free do not count; a third
    free label between the two may still join them."""
    voxel_size_mm: CellSize
    """Edge of the cubic cells, mm."""
    neighbourhood: Literal["faces", "edges", "corners"]
    """What an obstacle cell shares with a free one to be on the boundary: a face (6 neighbours), a
    face or an edge (18), or also a corner (26); [Kuntz2017] says "adjacent"."""
    inside_patient_mm: Annotated[tuple[tuple[float, float, float], ...], Field(max_length=1)]
    """A point within the part to move in, patient LPS mm; with none the largest part is taken."""
    smallest_part_ml: Annotated[float, Field(ge=0)]
    """Smaller parts of the free labels count as obstacle, ml."""
    volume_tolerance: Annotated[float, Field(gt=0, le=1)]
    """Share of the labels' volume by which the free cells' volume may differ before it is said."""


class FindEntryCorridorsParameters(Parameters):
    """What a straight needle through the chest wall has to keep to."""

    wall_labels: Annotated[tuple[Name, ...], Field(min_length=1)]
    """Names of the labels that a needle may pass."""
    bone_labels: Annotated[tuple[Name, ...], Field(min_length=1)]
    """Names of the labels whose distance from the needle the table tells."""
    needle_radius_mm: Annotated[float, Field(gt=0, le=10)]
    """Outer radius of the needle or its sheath, mm."""
    margin_mm: Annotated[float, Field(ge=0, le=30)]
    """Least distance between the needle's side and bone or any other labelled organ, mm."""
    thickest_wall_mm: Annotated[float, Field(gt=0, le=300)]
    """Longest way of a needle from skin to free space, mm."""
    tip_depth_mm: Annotated[float, Field(ge=0, le=100)]
    """How far the needle must be able to go on into the free space, mm."""
    largest_tilt_deg: Annotated[float, Field(ge=0, le=80)]
    """Largest angle between the needle and the skin's inward normal, degrees."""
    tilt_step_deg: Annotated[float, Field(ge=1, le=45)]
    """Angle between neighbouring directions that are tried, degrees."""
    skin_spacing_mm: Annotated[float, Field(ge=1, le=20)]
    """Distance between the points of the skin that are tried, and cell of the map, mm."""
    step_mm: Annotated[float, Field(ge=0.05, le=2)]
    """Distance of the places along a needle that are looked at, mm."""
    candidate_spacing_mm: Annotated[float, Field(ge=1, le=200)]
    """Least distance on the skin between the entries that are listed, mm."""
    enough_clearance_mm: Annotated[float, Field(ge=0, le=100)]
    """Distance between the needle's side and bone beyond which more is no better: then entries are
    ordered by the wall's thickness, mm."""


class BuildSurfacesParameters(Parameters):
    """How finely surfaces follow their labels."""

    outer_labels: tuple[Name, ...]
    """Names of the labels that reach the skin: their surface is the skin, which bounds all labels
    together."""
    voxel_size_mm: CellSize
    """Edge of the cubic cells on which surfaces are found, mm."""
    voxel_size_mm_by_label: dict[Name, CellSize]
    """Edge of the cells for single labels, mm."""
    smoothing_steps: Annotated[int, Field(ge=0, le=100)]
    """Passes of Taubin's smoothing, which keeps the volume [Taubin1995]; without unit."""
    volume_tolerance: Annotated[float, Field(gt=0, le=1)]
    """Share of a label's volume by which its surface may differ before it is said; no unit."""
    triangles: TriangleCount
    """Triangles that each surface should have."""
    triangles_by_label: dict[Name, TriangleCount]
    """Triangles that the surfaces of single labels should have."""


class SamplePointCloudParameters(Parameters):
    """How densely surfaces are sampled."""

    spacing_mm: Annotated[float, Field(ge=0.2, le=50)]
    """Least distance between two points of one surface; every place of a surface has a point
    within 1.25 of it, mm."""
    seed: Annotated[int, Field(ge=0)]
    """Seed of the order in which places are tried; no unit."""


class MeasureLabelsParameters(Parameters):
    """Which labels are also measured together."""

    groups: dict[Name, tuple[Name, ...]]
    """Name of a sum, and the labels that it adds up; sums of labels that are not there are left
    out."""
