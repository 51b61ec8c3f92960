"""Parameters of the segmentation of CTs; their values stand in catalog/parameters."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from nodes.parameters import Parameters

Radius = Annotated[float, Field(ge=0, le=50)]
PositiveRadius = Annotated[float, Field(gt=0, le=500)]
Volume = Annotated[float, Field(ge=0, le=10_000)]
Point = tuple[float, float, float]
CtLabel = Literal["body", "bone", "left_lung", "right_lung", "airway", "effusion"]


class Ball(Parameters):
    """A ball in the patient."""

    shape: Literal["ball"]
    """Says that it is a ball."""
    centre_patient_mm: Point
    """Its centre, LPS mm."""
    radius_mm: PositiveRadius
    """Its radius, mm."""


class Box(Parameters):
    """A box along the patient's axes."""

    shape: Literal["box"]
    """Says that it is a box."""
    lowest_patient_mm: Point
    """Its right, anterior, inferior corner, LPS mm."""
    highest_patient_mm: Point
    """Its left, posterior, superior corner, LPS mm."""

    @model_validator(mode="after")
    def _has_room(self) -> "Box":
        pairs = zip(self.lowest_patient_mm, self.highest_patient_mm, strict=True)
        if any(low >= high for low, high in pairs):
            raise ValueError("each of lowest_patient_mm is below that of highest_patient_mm")
        return self


class Disc(Parameters):
    """A piece of a plane, cut round."""

    shape: Literal["disc"]
    """Says that it is a disc."""
    centre_patient_mm: Point
    """Its centre, LPS mm."""
    normal_patient: Point
    """The direction across it, of any length above 0; without unit."""
    radius_mm: PositiveRadius
    """Its radius, mm."""
    thickness_mm: PositiveRadius
    """Its thickness, mm; from two voxels on nothing grows through it."""

    @model_validator(mode="after")
    def _has_direction(self) -> "Disc":
        if not any(self.normal_patient):
            raise ValueError("normal_patient has a length above 0")
        return self


Solid = Annotated[Ball | Box | Disc, Field(discriminator="shape")]


class Correction(Parameters):
    """A piece of the image that a person labels."""

    label: str
    """The label to paint; "background" takes the labels away."""
    within: Solid
    """Where to paint it."""


class SegmentCtParameters(Parameters):
    """What to look for in a CT, thresholds and sizes that tell it apart, and the person's hand."""

    labels: tuple[CtLabel, ...]
    """Labels to look for; "body" is always there, the others are all inside of it."""
    barriers: tuple[Solid, ...]
    """Balls, boxes and discs through which nothing grows."""
    corrections: tuple[Correction, ...]
    """Labels painted by hand over the result, in this order."""
    body_threshold_hu: Annotated[float, Field(ge=-900, le=-150)]
    """Tissue is at or above it and air below it when the body is cut out, HU."""
    table_opening_mm: Radius
    """What is thinner than twice this in the axial plane does not join body and table, mm."""
    table_edge_mm: Radius
    """A table is told by edges this wide on either side of the body, mm; 0: none is looked for."""
    table_straightness_mm: Radius
    """How far a table's top may lie off a straight line, mm."""
    table_slices_share: Annotated[float, Field(gt=0.5, le=1)]
    """Least share of the slices, and of an edge's width, in which a table is seen, no unit."""
    smallest_limb_bone_ml: Volume
    """A part beside the trunk belongs to the body if it holds this much bone, ml."""
    smoothing_mm: Annotated[float, Field(ge=0, le=5)]
    """Standard deviation of the Gaussian that quietens noise before the airway grows, mm."""
    airway_seeds_patient_mm: tuple[Point, ...]
    """Points in the airway, LPS mm; with none, the trachea is looked for."""
    airway_reach_mm: Annotated[float, Field(gt=0, le=500)]
    """How far from the patient's middle the airway is followed to either side, mm."""
    trachea_threshold_hu: Annotated[float, Field(ge=-1024, le=-500)]
    """Air in the trachea is below it, HU."""
    smallest_trachea_mm2: Annotated[float, Field(gt=0, le=1000)]
    """Smallest cross-section of the trachea's air, mm^2."""
    largest_trachea_mm2: Annotated[float, Field(gt=0, le=5000)]
    """Largest cross-section of the trachea's air, mm^2."""
    trachea_roundness: Annotated[float, Field(ge=0, le=1)]
    """Least share of the circle around it that the trachea's cross-section fills, no unit."""
    shortest_trachea_mm: Annotated[float, Field(gt=0, le=200)]
    """A column of round air is a trachea from this length on, mm."""
    airway_step_hu: Annotated[float, Field(ge=1, le=200)]
    """By how much the threshold rises from step to step while the airway grows, HU."""
    airway_jump_ml: Annotated[float, Field(gt=0, le=1000)]
    """A step that adds more than this has broken into the lung and is undone, ml."""
    smallest_airway_ml: Volume
    """A smaller airway is a bronchus or a bubble and no whole airway, ml."""
    largest_airway_ml: Annotated[float, Field(gt=0, le=1000)]
    """No airway holds more air, ml."""
    airway_wall_hu: Annotated[float, Field(ge=-900, le=-150)]
    """The airway's air ends where values rise above it, HU."""
    airway_wall_mm: Radius
    """How far around the grown airway its wall is looked for, mm."""
    lung_threshold_hu: Annotated[float, Field(ge=-900, le=-150)]
    """Lung is below it until its own density is known, HU."""
    soft_tissue_hu: Annotated[float, Field(ge=-50, le=100)]
    """Soft tissue beside lung and bone; their borders lie at half height to it, HU."""
    lung_closing_mm: Radius
    """Vessels in the lung narrower than twice this are counted as lung, mm."""
    smallest_lung_ml: Volume
    """Smaller air pockets inside the body are not lung (stomach, bowel), ml."""
    largest_lung_ml: Annotated[float, Field(gt=0, le=20_000)]
    """No lung is larger, ml."""
    usual_lungs_ml: tuple[Volume, Volume]
    """Lungs that hold less or more together are told, ml."""
    gas_mean_hu: Annotated[float, Field(ge=-1024, le=-900)]
    """An air pocket with a mean below it is bare gas (stomach, bowel), not lung, HU."""
    coarse_mm: Annotated[float, Field(gt=0, le=10)]
    """Voxel size about which touching lungs are parted and effusions are looked for, mm."""
    left_lung_seeds_patient_mm: tuple[Point, ...]
    """Points in the left lung, LPS mm; with none, it is told by its side of the spine."""
    right_lung_seeds_patient_mm: tuple[Point, ...]
    """Points in the right lung, LPS mm; with none, it is told by its side of the spine."""
    smallest_side_share: Annotated[float, Field(ge=0, le=0.4)]
    """A part with less than this share of the lungs' air is no lung of its own, no unit."""
    widest_lung_contact_mm: Radius
    """Half the width of the widest place where the two lungs may touch, mm."""
    effusion_seeds_patient_mm: tuple[Point, ...]
    """Points in an effusion, LPS mm; with none, fluid beside the lungs is looked for."""
    lowest_effusion_hu: Annotated[float, Field(ge=-50, le=50)]
    """Mean of the thinnest effusion, HU."""
    highest_effusion_hu: Annotated[float, Field(ge=-50, le=100)]
    """Mean of the densest effusion that is found without a seed, HU."""
    effusion_tolerance_hu: Annotated[float, Field(ge=0, le=50)]
    """How far places in an effusion may lie outside of those means, HU."""
    quiet_percent: Annotated[float, Field(gt=0, lt=100)]
    """This share of the tissue is quiet enough to show the noise alone, %."""
    effusion_search_mm: Annotated[float, Field(ge=0, le=10)]
    """Standard deviation of the Gaussian over which fluid is looked for, mm."""
    effusion_smoothing_mm: Annotated[float, Field(ge=0, le=10)]
    """Standard deviation of the Gaussian over which an effusion's border is found, at least, mm."""
    effusion_noise_sigmas: Annotated[float, Field(ge=0, le=6)]
    """The Gaussian is wide enough to make noise so many times smaller than half the contrast
    between fluid and wall, no unit."""
    effusion_outside_share: Annotated[float, Field(ge=0, le=1)]
    """Least share of an effusion that lies between lung and chest wall, no unit."""
    effusion_contact_share: Annotated[float, Field(gt=0, le=1)]
    """Further fluid of the same value counts if this share of its surface lies on the lung."""
    smallest_layer_ml: Volume
    """Such further fluid has at least this volume, ml."""
    effusion_film_mm: Radius
    """Fluid thinner than two voxels counts within this distance of the lung only, mm."""
    effusion_dent_mm: Radius
    """Fluid this near to an effusion that was filled as a dent of the lung counts, mm."""
    effusion_taper_mm: Radius
    """How far such a thin end may reach out from a layer of three voxels or more, mm."""
    smallest_effusion_ml: Volume
    """Less fluid is not called an effusion, ml."""
    largest_effusion_ml: Volume
    """No effusion of one chest is larger, ml."""
    skin_mm: Radius
    """No effusion lies less than this under the skin, mm."""
    largest_skin_effusion_ml: Volume
    """More of an effusion so near to the skin is a leak, ml."""
    fat_hu: Annotated[float, Field(ge=-200, le=-30)]
    """Fat, HU; the border between it and fluid lies halfway."""
    bone_threshold_hu: Annotated[float, Field(ge=80, le=700)]
    """Bone is at or above it, HU."""
    bone_closing_mm: Radius
    """Marrow narrower than twice this between bright bone is counted as bone, mm."""
    smallest_bone_ml: Volume
    """Smaller bright parts are dropped (calcifications, noise), ml."""
    largest_bone_ml: Annotated[float, Field(gt=0, le=20_000)]
    """No skeleton is larger, ml."""
    largest_marrow_mm2: Annotated[float, Field(ge=0, le=10_000)]
    """What bone surrounds in a plane is marrow up to this area, mm^2."""
    spongy_hu: Annotated[float, Field(ge=50, le=300)]
    """The mean of spongy bone is at or above it, that of the spinal canal below it, HU."""
    metal_hu: Annotated[float, Field(ge=1500, le=32767)]
    """No tissue is as dense as this, HU."""
    smallest_metal_ml: Volume
    """From this volume on, metal is told to the reader, ml."""
    cortex_reach_mm: Radius
    """How far from a bone's border its peak is looked for, mm."""
    bone_bloom_mm: Radius
    """How thick the blurred rim around a bone is at most, mm."""
    cortex_hu: Annotated[float, Field(ge=300, le=3071)]
    """Brighter peaks (metal, teeth) count as this when half heights are taken, HU."""

    @property
    def seeds_patient_mm(self) -> dict[str, tuple[Point, ...]]:
        """The person's seeds by label."""
        return {
            "airway": self.airway_seeds_patient_mm,
            "left_lung": self.left_lung_seeds_patient_mm,
            "right_lung": self.right_lung_seeds_patient_mm,
            "effusion": self.effusion_seeds_patient_mm,
        }
