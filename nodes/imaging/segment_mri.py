"""Head, skull, the two halves of the brain and its ventricles in a T1-weighted head MRI."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, UInt8

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume, spacing_mm
from nodes.geometry.masks import largest_part
from nodes.geometry.regridding import Grid, regrid_mask
from nodes.imaging.brain_surface import fill_surface, grow_brain_surface
from nodes.imaging.hand_labels import GRID_ROUNDING, check_given_labels, replace_labels
from nodes.imaging.mri_brain import even_intensities, find_remains, find_tissue, share_near_skin
from nodes.imaging.mri_halves import Plane, find_midplane, left_half, side_of
from nodes.imaging.mri_head import Head, find_head, find_range, is_skull_stripped
from nodes.imaging.mri_skull import find_braincase, find_skull, open_base, shell_skull
from nodes.imaging.mri_ventricles import find_ventricles
from nodes.imaging.parameters import SegmentMriParameters
from nodes.imaging.working_grid import to_working_grid

NAMES = ("head", "skull", "left_brain", "right_brain", "ventricles")
ML_IN_MM3 = 1000.0
Mask = Bool[np.ndarray, "i j k"]
Voxels = Float32[np.ndarray, "i j k"]
Affine = Float[np.ndarray, "4 4"]


class HeadParts(NamedTuple):
    """What was found on a working grid; `head` holds all inside the skin, also the brain."""

    patient_from_index: Affine
    head: Mask
    skull: Mask
    brain: Mask
    ventricles: Mask | None
    midplane: Plane
    stripped: bool


def segment_mri(mri: Volume, given_labels: LabelMap, parameters: SegmentMriParameters) -> LabelMap:
    """Label all that is inside the skin of a head.

    "left_brain" and "right_brain" are the patient's sides of the mid-sagittal plane, from cortex to
    brain stem, narrow sulci included; "ventricles" are the lateral ones and what joins them;
    "skull" is an estimate; "head" is all else inside the skin: scalp, muscles, fluid around the
    brain, eyes, air in the nose. A voxel has one label.

    Where the skull was stripped off the image, skull and head are shells around the brain.

    Parameters
    ----------
    mri : T1-weighted, any orientation and scale of intensities; the neck may be cut or not.
    given_labels : labels drawn by hand on the grid of `mri`, which win; without names: none.
    parameters : levels, sizes and limits.

    Returns
    -------
    Label map on the grid of `mri`; notices say what is estimated, missing or cut.

    Raises
    ------
    BadInput for a CT, for an image that shows no head, for a brain beyond human size, and for
    given labels that do not fit.
    """
    _refuse_other_images(mri, parameters)
    check_given_labels(mri, given_labels)
    parts = _find_parts(mri, parameters)
    origin = mri.origin.with_notice(*_notices(parts))
    found = LabelMap(_labels(parts, mri), mri.patient_from_index, NAMES, origin)
    return replace_labels(found, given_labels)


def _refuse_other_images(mri: Volume, parameters: SegmentMriParameters) -> None:
    if mri.unit == "HU":
        raise BadInput(
            "a volume in HU",
            "an MRI has intensities without unit; HU are a CT's",
            "use the pipeline for a CT, or read the series with modality: MR",
        )
    extent = spacing_mm(mri.patient_from_index) * mri.voxels.shape
    if extent.min() < parameters.smallest_extent_mm:
        raise BadInput(
            f"an image of {' x '.join(f'{side:.0f}' for side in extent)} mm",
            f"a head needs {parameters.smallest_extent_mm:g} mm or more along each side",
            "give a series that shows the whole brain, not a slab of it",
        )


def _find_parts(mri: Volume, parameters: SegmentMriParameters) -> HeadParts:
    """Find the head on coarse voxels, and all else on fine ones."""
    size = parameters.working_voxel_mm
    lowest, highest = find_range(mri, parameters)
    coarse, coarse_from = to_working_grid(mri, parameters.skin_voxel_mm, lowest)
    head = find_head(coarse, coarse_from, (lowest, highest), parameters)
    stripped = is_skull_stripped(coarse, head, parameters)
    voxels, patient_from_index = to_working_grid(mri, size, lowest)
    skin = _regridded(head.mask, coarse_from, Grid(patient_from_index, voxels.shape))
    if stripped:
        brain = find_remains(voxels > head.levels.background, size, parameters)
        values = even_intensities(voxels, brain, lowest)
    else:
        surface = _within_surface(voxels, patient_from_index, head, skin, parameters)
        values = even_intensities(voxels, surface, lowest)
        brain = find_tissue(values, surface, skin, size, parameters)
    _refuse_inhuman(np.count_nonzero(brain) * size**3 / ML_IN_MM3, parameters)
    midplane = find_midplane(values, brain, patient_from_index, parameters)
    left_mm = side_of(midplane, voxels.shape, patient_from_index)
    ventricles = find_ventricles(values, brain, left_mm, size, parameters)
    braincase = find_braincase(brain, size, parameters)
    if stripped:
        skull = shell_skull(braincase, parameters.skull_thickness_mm, size)
        skin = shell_skull(braincase | skull, parameters.scalp_thickness_mm, size)
    else:
        scaled = (voxels - lowest) / (head.levels.brain - lowest)
        skull = find_skull(scaled.astype(np.float32), skin, braincase, size, parameters)
    skin = skin | skull | braincase
    skull = open_base(skull, brain, left_mm, size, parameters)
    return HeadParts(patient_from_index, skin, skull, brain, ventricles, midplane, stripped)


def _within_surface(
    voxels: Voxels,
    patient_from_index: Affine,
    head: Head,
    skin: Mask,
    parameters: SegmentMriParameters,
) -> Mask:
    """Return what is within the surface that lies on the brain.

    Where bone is thin or the dura bright, the surface can break out to the scalp; then a higher
    threshold holds it back.
    """
    size = parameters.working_voxel_mm
    centre = head.centre_patient_mm - patient_from_index[:3, 3]
    inside = skin
    for threshold in parameters.surface_thresholds:
        steps, levels = parameters.surface_steps, head.levels
        surface = grow_brain_surface(voxels, size, centre, head.radius_mm, levels, threshold, steps)
        inside = fill_surface(*surface, voxels.shape, size)
        if share_near_skin(inside, skin, size, parameters) <= parameters.largest_leak_share:
            break
    return inside


def _regridded(mask: Mask, patient_from_index: Affine, grid: Grid) -> Bool[np.ndarray, "a b c"]:
    result = np.zeros(grid.shape, bool)
    box, inside = regrid_mask(mask, patient_from_index, grid, GRID_ROUNDING)
    result[box] = inside
    return result


def _refuse_inhuman(volume_ml: float, parameters: SegmentMriParameters) -> None:
    low, high = parameters.smallest_brain_ml, parameters.largest_brain_ml
    if not low <= volume_ml <= high:
        raise BadInput(
            f"what was found as brain has {volume_ml:.0f} ml",
            f"a human brain has {low:g} to {high:g} ml, ventricles and narrow sulci included",
            "check that the image is a T1-weighted MRI of a whole head with its spacing in mm, or"
            " use a label map of your own (pipeline label_maps)",
        )


def _labels(parts: HeadParts, mri: Volume) -> UInt8[np.ndarray, "i j k"]:
    """Lay the parts on the image's own grid, the inner ones over the outer ones."""
    grid = Grid(mri.patient_from_index, mri.voxels.shape)
    labels = np.zeros(grid.shape, np.uint8)
    for name, mask in (("head", parts.head), ("skull", parts.skull)):
        labels[_regridded(mask, parts.patient_from_index, grid)] = NAMES.index(name) + 1
    brain = largest_part(_regridded(parts.brain, parts.patient_from_index, grid))
    labels[brain] = NAMES.index("right_brain") + 1
    left = left_half(parts.midplane, brain, grid.patient_from_index)
    labels[left] = NAMES.index("left_brain") + 1
    if parts.ventricles is not None:
        ventricles = _regridded(parts.ventricles, parts.patient_from_index, grid)
        labels[ventricles & brain] = NAMES.index("ventricles") + 1
    return labels


def _notices(parts: HeadParts) -> list[str]:
    notices = [
        '"head" is all inside the skin that has no label of its own: scalp, muscles, fluid around'
        " the brain, eyes, air in nose and sinuses",
        "the skull is an estimate: its inner side is the brain's outside and a gap of fluid, since"
        " bone and fluid are both dark in MRI",
    ]
    if parts.stripped:
        notices = [
            "skull and head are estimated from the brain's shape: the image is skull-stripped"
        ]
    if parts.ventricles is None:
        notices.append("no pair of lateral ventricles was seen, so the label ventricles is empty")
    else:
        notices.append(
            "ventricles are the lateral ones and what joins them; the third and fourth may be"
            " labelled as brain"
        )
    return notices + _cut_notices(parts)


def _cut_notices(parts: HeadParts) -> list[str]:
    """Say at which sides the image's edge cuts the head and the brain."""
    sides = ("right", "left", "front", "back", "bottom", "top")
    notices = []
    for name, mask in (("head", parts.head), ("brain", parts.brain)):
        ends = [mask.take(end, axis).any() for axis in range(3) for end in (0, -1)]
        if any(ends):
            cut = ", ".join(side for side, touched in zip(sides, ends, strict=True) if touched)
            notices.append(f"the image's edge cuts the {name}: {cut}")
    return notices
