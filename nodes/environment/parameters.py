"""Parameters of the environment stages; their values stand in catalog/parameters."""

from typing import Annotated

from pydantic import Field

from nodes.parameters import Parameters


class BuildOccupancyGridParameters(Parameters):
    """Where the robot may move and how finely space is cut."""

    free_label: Annotated[str, Field(min_length=1)]
    """Name of the label whose inside is free; everything else is obstacle."""
    voxel_size_mm: Annotated[float, Field(ge=0.2, le=20)]
    """Edge of the cubic cells, mm."""


class BuildSurfacesParameters(Parameters):
    """How finely surfaces follow their labels."""

    voxel_size_mm: Annotated[float, Field(ge=0.2, le=20)]
    """Edge of the cubic cells on which surfaces are found, mm."""
    smoothing_steps: Annotated[int, Field(ge=0, le=100)]
    """Passes of Taubin's smoothing, which keeps the volume [Taubin1995]; without unit."""
    volume_tolerance: Annotated[float, Field(gt=0, le=1)]
    """Share of a label's volume by which its surface may differ before it is said; no unit."""
    triangles: Annotated[int, Field(ge=100, le=2_000_000)]
    """Triangles that each surface should have at most."""
