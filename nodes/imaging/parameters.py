"""Parameters of the imaging stages; their values stand in catalog/parameters."""

from typing import Annotated, Literal

from pydantic import Field

from nodes.parameters import Parameters

Tolerance = Annotated[float, Field(gt=0, le=10)]
Radius = Annotated[float, Field(ge=0, le=50)]
Volume = Annotated[float, Field(ge=0, le=10_000)]


class MakeThoraxPhantomParameters(Parameters):
    """Size, scan and disease of the thorax phantom."""

    chest_width_mm: Annotated[float, Field(ge=100, le=600)]
    """Width of the chest at its widest, mm; everything else scales with it."""
    pixel_spacing_mm: Annotated[float, Field(ge=0.4, le=6)]
    """Distance between pixel centres within a slice, mm."""
    slice_thickness_mm: Annotated[float, Field(ge=0.4, le=12)]
    """Distance between slices and thickness of each, mm."""
    effusion_share: Annotated[float, Field(ge=0, le=0.7)]
    """Share of the right pleural cavity's volume that is fluid, without unit."""
    noise_sd_hu: Annotated[float, Field(ge=0, le=200)]
    """Standard deviation of the white noise in every voxel, HU."""
    seed: Annotated[int, Field(ge=0)]
    """Seed of all chance: noise, course of the vessels, order of the slices; without unit."""


class ReadVolumeParameters(Parameters):
    """What to read and how even a stack of slices has to be."""

    modality: Literal["CT", "MR", "any"]
    """DICOM modality of the wanted series; "any" takes the largest series of all."""
    position_tolerance_mm: Tolerance
    """How far a slice may lie from its place in an evenly spaced straight stack, mm."""
    orientation_tolerance_deg: Tolerance
    """How far the axes of two slices of one stack may point apart, degrees."""
    tilt_tolerance_deg: Tolerance
    """How far the stack may lean from the normal of its slices before it counts as tilted, deg."""
    smallest_spacing_mm: Annotated[float, Field(gt=0, le=1)]
    """Voxels with a shorter edge are a mistake of units, mm."""
    largest_extent_mm: Annotated[float, Field(ge=500, le=10_000)]
    """Volumes with a longer side are a mistake of units, mm; a person and the table fit in it."""
    lowest_hu: Annotated[float, Field(le=-1000, ge=-32768)]
    """CT values below it are set to it, HU; air is -1000 by definition."""


class SegmentCtParameters(Parameters):
    """Thresholds and sizes that tell body, bone and lungs apart in a CT."""

    body_threshold_hu: Annotated[float, Field(ge=-900, le=-150)]
    """Tissue is at or above it and air below it when the body is cut out, HU."""
    table_opening_mm: Radius
    """What is thinner than twice this in the axial plane does not join body and table, mm."""
    lung_threshold_hu: Annotated[float, Field(ge=-900, le=-150)]
    """Lung is below it, HU."""
    lung_closing_mm: Radius
    """Vessels in the lung narrower than twice this are counted as lung, mm."""
    smallest_lung_ml: Volume
    """Smaller air pockets inside the body are not lung (stomach, bowel), ml."""
    gas_mean_hu: Annotated[float, Field(ge=-1024, le=-900)]
    """An air pocket with a mean below it is bare gas (stomach, bowel), not lung, HU."""
    bone_threshold_hu: Annotated[float, Field(ge=80, le=700)]
    """Bone is at or above it, HU."""
    bone_closing_mm: Radius
    """Marrow narrower than twice this between bright bone is counted as bone, mm."""
    smallest_bone_ml: Volume
    """Smaller bright parts are dropped (calcifications, noise), ml."""
