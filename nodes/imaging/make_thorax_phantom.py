"""A thorax of human size with known anatomy, as a scanner would deliver it."""

from functools import partial

import numpy as np
from jaxtyping import Float32, Int16

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from nodes.imaging import thorax_anatomy as anatomy
from nodes.imaging import thorax_bones as bones
from nodes.imaging import thorax_lungs as lungs
from nodes.imaging.artefacts import ImageFiles, Slice
from nodes.imaging.painting import Canvas
from nodes.imaging.parameters import MakeThoraxPhantomParameters
from nodes.imaging.thorax_adhesions import paint_adhesions
from nodes.imaging.thorax_trees import paint_airway, paint_vessels

# Half the field of view and its middle, mm, for a chest of the reference width.
HALF_FIELD, FIELD_MIDDLE_Y = (192.0, 144.0), 9.0
HIGHEST_STORED_HU = 3071  # of 12-bit CT
FWHM_IN_SD = 2.354820045  # full width at half maximum of a normal distribution: 2 sqrt(2 ln 2)
MOST_VOXELS = 400_000_000  # about 4 GB while it is painted


def make_thorax_phantom(
    parameters: MakeThoraxPhantomParameters,
) -> tuple[ImageFiles, LabelMap]:
    """Draw the phantom: chest wall, bones, lungs, airway, heart, and fluid around one lung.

    Parameters
    ----------
    parameters : size, scan and disease.

    Returns
    -------
    image_files : one CT series, simulated, its slices in shuffled order as files often are.
    truth : "body" (all tissue that is nothing else), "bone", "left_lung", "right_lung" (with
        vessels and small bronchi), "airway" (air in trachea, main and lobar bronchi, down to a
        width of 8 mm in a healthy lung, and as far as it hangs together on this grid),
        "effusion", "adhesion"; exact at voxel centres.

    Raises
    ------
    BadInput where the image would have too many voxels.
    """
    chance = np.random.default_rng(parameters.seed)
    canvas, patient_from_index = _empty_canvas(parameters)
    _paint_thorax(canvas, parameters)
    voxels = _measured(canvas.hu, parameters, chance)
    origin = Origin("thorax phantom", simulated=True)
    truth = LabelMap(canvas.labels, patient_from_index, anatomy.NAMES, origin)
    slices = _slices(voxels, patient_from_index)
    shuffled = tuple(slices[index] for index in chance.permutation(len(slices)))
    return ImageFiles(slices=shuffled, simulated=True), truth


def _empty_canvas(parameters: MakeThoraxPhantomParameters) -> tuple[Canvas, np.ndarray]:
    """Return air on the grid, with the voxels' places in mm of the reference chest."""
    scale = parameters.chest_width_mm / anatomy.REFERENCE_WIDTH
    pixel, thickness = parameters.pixel_spacing_mm, parameters.slice_thickness_mm
    height = (anatomy.HIGHEST - anatomy.LOWEST) * scale
    field = np.array([2 * HALF_FIELD[0] * scale, 2 * HALF_FIELD[1] * scale, height])
    spacing = np.array([pixel, pixel, thickness])
    shape = np.maximum(np.rint(field / spacing).astype(int), 2)
    _refuse_too_many(shape)
    middle = np.array([0.0, FIELD_MIDDLE_Y * scale, 0.0])
    patient_from_index = np.diag([*spacing, 1.0])
    patient_from_index[:3, 3] = middle - (shape - 1) / 2 * spacing
    x, y, z = (
        ((start + step * np.arange(count)) / scale).astype(np.float32)
        for start, step, count in zip(patient_from_index[:3, 3], spacing, shape, strict=True)
    )
    build = anatomy.draw_build(parameters.variation, parameters.seed)
    canvas = Canvas(
        axes=(x, y, z),
        spacing=(pixel / scale, pixel / scale, thickness / scale),
        bend=partial(anatomy.bend, build=build),
        hu=np.full(shape, np.float32(anatomy.AIR)),
        labels=np.zeros(shape, np.uint8),
    )
    return canvas, patient_from_index


def _refuse_too_many(shape: np.ndarray) -> None:
    if shape.prod(dtype=float) > MOST_VOXELS:
        raise BadInput(
            f"a phantom of {shape[0]} x {shape[1]} x {shape[2]} voxels",
            f"it has at most {MOST_VOXELS:,} voxels",
            "raise pixel_spacing_mm or slice_thickness_mm, or lower chest_width_mm",
        )


def _paint_thorax(canvas: Canvas, parameters: MakeThoraxPhantomParameters) -> None:
    """Paint from the outside in: what comes later lies over what came before.

    Each part has chance of its own, so that a change of one leaves the others as they are.
    """
    build = anatomy.draw_build(parameters.variation, parameters.seed)
    ill = anatomy.LEFT if parameters.effusion_side == "left" else anatomy.RIGHT
    share = parameters.effusion_share
    film = parameters.thinnest_fluid_mm
    collapse = lungs.draw_in(ill, build, parameters.lung_lies, share, film)
    collapses = {ill: collapse, -ill: lungs.HEALTHY}
    anatomy.paint_trunk(canvas, build)
    bones.paint_ribs(canvas, build)
    bones.paint_plates(canvas)
    bones.paint_spine(canvas, build)
    anatomy.paint_mediastinum(canvas, build)
    lungs.paint_lungs(canvas, build, ill, collapse, share)
    for side in (anatomy.RIGHT, anatomy.LEFT):
        chance = np.random.default_rng([parameters.seed, 2, side + 1])
        paint_vessels(canvas, side, collapses[side], chance)
    paint_airway(canvas, collapses, np.random.default_rng([parameters.seed, 3]))
    if share > 0 and parameters.adhesions > 0:
        lung, cavity = lungs.lung(ill, build, collapse), lungs.pleural_cavity(ill, build)
        chance = np.random.default_rng([parameters.seed, 4])
        paint_adhesions(canvas, lung, cavity, parameters.adhesions, ill, chance)
    for side, label in ((1, anatomy.LEFT_LUNG), (-1, anatomy.RIGHT_LUNG)):
        here = side * canvas.axes[0].reshape(-1, 1, 1) > 0  # bronchi that the grid tears apart
        canvas.labels[lungs.find_islands(canvas.labels, anatomy.AIRWAY) & here] = label
        # Walls that bronchi have cut off.
        canvas.labels[lungs.find_islands(canvas.labels, label)] = anatomy.BODY


def _measured(
    hu: Float32[np.ndarray, "i j k"],
    parameters: MakeThoraxPhantomParameters,
    chance: np.random.Generator,
) -> Int16[np.ndarray, "i j k"]:
    """Blur within the slices and add noise, which the same blur has made coarser."""
    noise = chance.standard_normal(hu.shape, dtype=np.float32)
    if parameters.blur_mm > 0:
        from scipy import ndimage

        sd = parameters.blur_mm / FWHM_IN_SD / parameters.pixel_spacing_mm
        hu = ndimage.gaussian_filter(hu, (sd, sd, 0), mode="nearest")
        noise = ndimage.gaussian_filter(noise, (sd, sd, 0), mode="wrap")
        noise /= noise.std()
    hu = hu + noise * np.float32(parameters.noise_sd_hu)
    return np.rint(np.clip(hu, -1024, HIGHEST_STORED_HU)).astype(np.int16)


def _slices(voxels: Int16[np.ndarray, "i j k"], patient_from_index: np.ndarray) -> list[Slice]:
    slices = []
    for k in range(voxels.shape[2]):
        patient_from_pixel = patient_from_index.copy()
        patient_from_pixel[:3, 2] = (0, 0, 1)
        patient_from_pixel[:3, 3] += k * patient_from_index[:3, 2]
        slices.append(Slice(voxels[:, :, k].T, patient_from_pixel, 1, "CT", "HU"))
    return slices
