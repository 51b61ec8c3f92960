"""Parameters of the imaging stages; their values stand in catalog/parameters."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from nodes.imaging.series_key import name_series
from nodes.parameters import Parameters

SeriesName = Annotated[str, BeforeValidator(name_series)]
Tolerance = Annotated[float, Field(gt=0, le=10)]
Radius = Annotated[float, Field(ge=0, le=50)]
Volume = Annotated[float, Field(ge=0, le=10_000)]
Percentile = Annotated[float, Field(ge=0, le=100)]
Level = Annotated[float, Field(gt=0, lt=1)]


class MakeThoraxPhantomParameters(Parameters):
    """Size, scan and disease of the thorax phantom."""

    chest_width_mm: Annotated[float, Field(ge=100, le=600)]
    """Width of the chest at its widest, mm; everything else scales with it."""
    pixel_spacing_mm: Annotated[float, Field(ge=0.4, le=6)]
    """Distance between pixel centres within a slice, mm."""
    slice_thickness_mm: Annotated[float, Field(ge=0.4, le=12)]
    """Distance between slices and thickness of each, mm."""
    effusion_share: Annotated[float, Field(ge=0, le=0.7)]
    """Share of one pleural cavity's volume that is fluid and no lung, without unit; 0: healthy."""
    thinnest_fluid_mm: Annotated[float, Field(ge=0, le=20)]
    """Where fluid would be thinner the lung lies on the wall, mm for a chest 350 mm wide."""
    effusion_side: Literal["left", "right"]
    """The patient's side that the effusion is on."""
    lung_lies: Literal["posterior", "anterior"]
    """Side of the effusion that the collapsed lung lies on: posterior in [Kuntz2017] Fig. 3."""
    adhesions: Annotated[int, Field(ge=0, le=12)]
    """Bands of tissue from the collapsed lung to the chest wall, 2 to 6 mm wide; their number."""
    variation: Annotated[float, Field(ge=0, le=1)]
    """How far the build may differ from the average one by chance: 0 not at all, 1 as far as
    people often do; without unit."""
    blur_mm: Annotated[float, Field(ge=0, le=5)]
    """Full width at half maximum of the scanner's blur within a slice, mm; makes noise coarser."""
    noise_sd_hu: Annotated[float, Field(ge=0, le=200)]
    """Standard deviation of the noise in a voxel, HU."""
    seed: Annotated[int, Field(ge=0)]
    """Seed of all chance: build, vessels, adhesions, noise, order of the slices; without unit."""


class CollapseLungParameters(Parameters):
    """Which lung collapses, how far and where to, and what fills the room that it leaves."""

    side: Literal["left", "right"]
    """The patient's side whose lung collapses."""
    collapsed_share: Annotated[float, Field(ge=0.05, le=0.8)]
    """Share of the old lung's volume that the lung leaves to the cavity, without unit."""
    lung_lies: Literal["posterior", "anterior", "medial"]
    """Where the collapsed lung lies: posterior in [Kuntz2017] Fig. 3."""
    flattening: Annotated[float, Field(ge=0.5, le=3)]
    """How much more the lung is drawn in towards that wall than across, as a power; no unit."""
    stalk_radius_mm: Annotated[float, Field(ge=4, le=30)]
    """Radius of the tissue by which the lung hangs on its hilum, mm."""
    smoothing_mm: Annotated[float, Field(ge=1, le=10)]
    """Standard deviation of the smoothing of the collapsed lung's surface, mm."""
    widest_vessel_mm: Annotated[float, Field(ge=5, le=60)]
    """Tissue or airway between parts of the lung is a vessel or bronchus in it where it is no
    wider, mm; what is wider is heart or liver."""
    bronchial_wall_mm: Annotated[float, Field(ge=0, le=8)]
    """Tissue this near to a bronchus in the lung is its wall, mm."""
    filling: Literal["fluid", "air"]
    """What fills the cavity: fluid of an effusion, or air of a pneumothorax."""
    fluid_hu: Annotated[float, Field(ge=-20, le=100)]
    """Value of the fluid, HU."""
    adhesions: Annotated[int, Field(ge=0, le=30)]
    """Strands of tissue between collapsed lung and chest wall, at most; their number."""
    adhesion_width_mm: Annotated[float, Field(ge=0.5, le=15)]
    """Width of a strand, mm; at least a voxel's diagonal is drawn."""
    smallest_lung_ml: Volume
    """A smaller lung is refused, ml."""
    largest_effusion_ml: Volume
    """A scan with more effusion than this is refused, ml: the lung has to be healthy."""
    seed: Annotated[int, Field(ge=0)]
    """Seed of all chance: places of the strands, noise; without unit."""


class ReadVolumeParameters(Parameters):
    """What to read, how even a stack of slices has to be, and when values are HU."""

    modality: Literal["CT", "MR", "any"]
    """DICOM modality of the wanted series; "any" takes all."""
    series: SeriesName
    """The wanted series: "" for the largest, its number in the list that an unclear choice shows,
    or its series instance UID (kept as a hash only)."""
    rival_share: Annotated[float, Field(gt=0, le=1)]
    """The largest series is chosen only if every other has at most this share of its voxels."""
    fewest_planes: Annotated[int, Field(ge=2, le=100)]
    """A volume has at least as many planes along each axis, without unit."""
    position_tolerance_mm: Tolerance
    """How far a slice may lie from its place in an evenly spaced straight stack, mm."""
    orientation_tolerance_deg: Tolerance
    """How far the axes of two slices of one stack may point apart, degrees."""
    tilt_tolerance_deg: Tolerance
    """How far the stack may lean from the normal of its slices before it is straightened, deg."""
    largest_tilt_deg: Annotated[float, Field(ge=0, le=60)]
    """A stack that leans more than this is no scan with a tilted gantry, degrees."""
    uneven_spacing: Literal["refuse", "resample"]
    """What to do with missing slices and uneven steps; "resample" fills them by interpolation."""
    largest_gap_mm: Annotated[float, Field(gt=0, le=50)]
    """Widest distance between two slices that may be filled by interpolation, mm."""
    smallest_spacing_mm: Annotated[float, Field(gt=0, le=1)]
    """Voxels with a shorter edge are a mistake of units, mm."""
    largest_extent_mm: Annotated[float, Field(ge=500, le=10_000)]
    """Volumes with a longer side are a mistake of units, mm; a person and the table fit in it."""
    air_hu: Annotated[float, Field(ge=-1000, le=-200)]
    """Values of a volume file count as HU only if the lowest is at or below this, HU."""
    hu_offset: Annotated[int, Field(ge=-8192, le=0)] | None
    """Added to CT values that are not known to be HU, which it makes HU; none: nothing is known."""
    lowest_hu: Annotated[float, Field(le=-1000, ge=-32768)]
    """CT values below it, and what a straightened scan does not cover, are set to it, HU."""
    metal_hu: Annotated[float, Field(ge=2000, le=32767)]
    """CT values above it are counted as metal and kept, HU."""


class PlaceLabelsParameters(Parameters):
    """How the labels of a person's files are called and which lies on top."""

    names: dict[str, str]
    """Label in the files -> our name, without unit; equal names are joined, "" leaves it out."""
    order: tuple[str, ...]
    """Our names from low to high: where labels overlap, a later one lies on top, and those not
    named lie below, the larger the lower; without unit."""
    smallest_voxels: Annotated[int, Field(ge=1, le=1_000_000)]
    """Labels with fewer voxels in their file are refused as a mistake, voxels."""
    grid_tolerance_voxels: Annotated[float, Field(gt=0, le=0.5)]
    """Voxels of two grids that lie this near to each other count as the same, voxels."""


class CombineLabelMapsParameters(PlaceLabelsParameters):
    """The same, and the common grid of label maps without an image."""

    voxel_size_mm: Annotated[float, Field(ge=0, le=10)]
    """Edge of the common grid's cubic voxels, mm; 0 takes the grid of the finest file."""
    margin_mm: Annotated[float, Field(ge=0, le=200)]
    """Empty space around all labels in a grid that was cut to them, mm."""
    most_voxels_million: Annotated[float, Field(gt=0, le=2000)]
    """A common grid with more voxels is refused as a mistake, millions."""


class CheckSitesParameters(Parameters):
    """When a site counts as being at a label."""

    tolerance_mm: Annotated[float, Field(ge=0, le=100)]
    """A site this far from a label's nearest voxel or nearer is at that label, mm."""


class SegmentMriParameters(Parameters):
    """Levels, sizes and limits by which a head MRI is taken apart.

    Levels of brightness are shares of the brain's median above the image's lowest level, after the
    bias field is divided out; so they hold for any scanner's scale.
    """

    working_voxel_mm: Annotated[float, Field(ge=0.5, le=3)]
    """Edge of the cubic voxels on which brain, ventricles and skull are found, mm."""
    skin_voxel_mm: Annotated[float, Field(ge=1, le=4)]
    """Edge of the cubic voxels on which the skin is found, mm."""
    smallest_extent_mm: Annotated[float, Field(ge=50, le=200)]
    """An image with a shorter side shows no whole brain, mm."""
    robust_percentiles: tuple[Percentile, Percentile]
    """Percentiles of all voxels that count as the lowest and highest level, %."""
    background_share: Level
    """Air is darker than this share of the way from the lowest level to Otsu's threshold."""
    smallest_skin_part_ml: Volume
    """Bright parts with less volume are noise and not skin, ml."""
    skin_closing_mm: Radius
    """Nostrils and ear canals narrower than twice this are inside the skin, mm."""
    skin_opening_mm: Radius
    """What is thinner than twice this does not join the head (ghosts, holders, cables), mm."""
    brain_height_mm: Annotated[float, Field(ge=80, le=200)]
    """The brain's middle is looked for down to this far below the top of the head, mm."""
    bone_depths_mm: tuple[Radius, Radius]
    """Bone is looked for between these depths below the surface of the upper head, mm."""
    least_bone_share: Annotated[float, Field(gt=0, lt=1)]
    """With less than this share of dark voxels there the skull was stripped off, no unit."""
    surface_thresholds: tuple[Level, ...]
    """Shares of the local brightness below which the brain's surface draws back, no unit; the next
    one is taken where the surface breaks out with the one before."""
    surface_steps: Annotated[int, Field(ge=100, le=10_000)]
    """Small moves in which the surface grows, no unit."""
    largest_leak_share: Annotated[float, Field(ge=0, lt=1)]
    """A surface with more than this share of its upper half in the scalp broke out, no unit."""
    darkest_tissue: Level
    """Brain is brighter: between fluid and grey matter; share of the brain's median."""
    brightest_tissue: Annotated[float, Field(gt=1, le=4)]
    """Brain is darker: between white matter and fat or vessels; share of the brain's median."""
    sure_brain_mm: Radius
    """As deep below the found surface it is brain, as far above it is not, mm."""
    sure_depth_mm: Radius
    """And it is brain only that deep below the skin, mm."""
    sure_scalp_mm: Radius
    """As near to the skin it is not brain, mm."""
    surface_reach_mm: Radius
    """How far outside of the surface brain may still lie, mm."""
    brain_opening_mm: Radius
    """What is thinner than twice this is cut from the brain (membranes, nerves, vessels), mm."""
    sulcus_closing_mm: Radius
    """Sulci narrower than twice this are counted as brain, mm."""
    smallest_brain_ml: Volume
    """A brain with less volume, or a head with less in its upper part, is refused, ml."""
    largest_brain_ml: Volume
    """A brain with more volume is refused, ml."""
    mirror_voxel_mm: Annotated[float, Field(ge=2, le=10)]
    """Distance of the points at which the brain is compared with its mirror image, mm."""
    largest_turn_deg: Annotated[float, Field(gt=0, le=45)]
    """How far the midplane's normal is looked for from the patient's x axis at first, degrees."""
    first_turns: Annotated[int, Field(ge=3, le=25)]
    """Number of angles that are tried at first in each of two directions, no unit."""
    least_symmetry: Annotated[float, Field(ge=0, lt=1)]
    """A brain whose mirror image correlates less with it is refused, no unit."""
    brightest_fluid: Level
    """Fluid in ventricles is darker; share of the brain's median."""
    ventricle_edge_mm: Radius
    """No ventricle lies nearer to the brain's outside, mm."""
    ventricle_depth_mm: Radius
    """The bodies of the lateral ventricles lie deeper than this below the brain's outside, mm."""
    midline_mm: Radius
    """Fluid nearer to the midplane does not tell a lateral ventricle from a cistern, mm."""
    ventricle_reach_mm: Radius
    """The bodies of the lateral ventricles lie nearer to the midplane than this, mm."""
    ventricle_closing_mm: Radius
    """Fluid in gaps narrower than twice this joins the two lateral ventricles, mm."""
    smallest_ventricles_ml: Volume
    """Less volume is not taken for the ventricles, ml."""
    largest_ventricles_ml: Volume
    """More volume is not taken for the ventricles, ml."""
    braincase_closing_mm: Radius
    """The inside of the skull does not follow clefts of the brain narrower than twice this, mm."""
    csf_gap_mm: Radius
    """Fluid and membranes between brain and skull, mm."""
    brightest_bone: Level
    """Compact bone is darker and scalp brighter; share of the brain's median."""
    skull_reach_mm: Annotated[float, Field(ge=10, le=60)]
    """The outer side of the skull is looked for where skin is at most this far from its inner
    side, mm."""
    skull_thickness_mm: Annotated[float, Field(gt=0, le=20)]
    """Thickness of the skull where it is not seen, mm."""
    thinnest_skull_mm: Annotated[float, Field(gt=0, le=20)]
    """The skull is at least as thick, mm."""
    thickest_skull_mm: Annotated[float, Field(gt=0, le=30)]
    """The skull is at most as thick, mm."""
    scalp_thickness_mm: Annotated[float, Field(gt=0, le=30)]
    """Thickness of the scalp where it was stripped off the image, mm."""
    foramen_radius_mm: Radius
    """Radius of the opening of the skull's base around the brain stem, mm."""
