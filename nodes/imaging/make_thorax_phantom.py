"""A thorax of human size with known anatomy, as a scanner would deliver it."""

import numpy as np
from jaxtyping import Float32, Int16

from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin
from nodes.imaging import thorax_anatomy as anatomy
from nodes.imaging.artefacts import ImageFiles, Slice
from nodes.imaging.parameters import MakeThoraxPhantomParameters
from nodes.imaging.solids import Canvas, paint

# Half the field of view and its middle, mm, for a chest of the reference width.
HALF_FIELD, FIELD_MIDDLE_Y = (192.0, 144.0), 9.0
HIGHEST_STORED_HU = 3071  # of 12-bit CT


def make_thorax_phantom(
    parameters: MakeThoraxPhantomParameters,
) -> tuple[ImageFiles, LabelMap]:
    """Draw the phantom: chest wall, bones, lungs, airway, heart, and fluid around the right lung.

    Parameters
    ----------
    parameters : size, scan and disease.

    Returns
    -------
    image_files : one CT series, simulated, its slices in shuffled order as files often are.
    truth : "body" (all tissue that is nothing else), "bone", "lungs" (with their vessels),
        "airway" (the air in trachea and main bronchi), "effusion"; exact at voxel centres.
    """
    chance = np.random.default_rng(parameters.seed)
    canvas, patient_from_index = _empty_canvas(parameters)
    _paint_thorax(canvas, parameters.effusion_share, chance)
    voxels = _measured(canvas.hu, parameters.noise_sd_hu, chance)
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
    middle = np.array([0.0, FIELD_MIDDLE_Y * scale, 0.0])
    patient_from_index = np.diag([*spacing, 1.0])
    patient_from_index[:3, 3] = middle - (shape - 1) / 2 * spacing
    x, y, z = (
        ((start + step * np.arange(count)) / scale).astype(np.float32)
        for start, step, count in zip(patient_from_index[:3, 3], spacing, shape, strict=True)
    )
    return Canvas(
        points=(x[:, None, None], y[None, :, None], z[None, None, :]),
        hu=np.full(shape, np.float32(anatomy.AIR)),
        labels=np.zeros(shape, np.uint8),
        blend_mm=float(np.cbrt(spacing.prod()) / scale),
    ), patient_from_index


def _paint_thorax(canvas: Canvas, effusion_share: float, chance: np.random.Generator) -> None:
    """Paint from the outside in: what comes later lies over what came before."""
    anatomy.paint_trunk(canvas)
    anatomy.paint_ribs(canvas)
    anatomy.paint_plates(canvas)
    anatomy.paint_spine(canvas)
    _paint_lungs(canvas, effusion_share)
    anatomy.paint_mediastinum(canvas)
    for side in (-1, 1):
        anatomy.paint_vessels(canvas, side, chance)
    anatomy.paint_airway(canvas)


def _paint_lungs(canvas: Canvas, effusion_share: float) -> None:
    """Paint the left lung, and the right one drawn together within its fluid.

    A collapsed lung holds the same tissue in less space, so its density grows by 1/(1 - share).
    """
    paint(canvas, anatomy.pleural_cavity(canvas.points, 1), anatomy.AERATED_LUNG, anatomy.LUNGS)
    cavity = anatomy.pleural_cavity(canvas.points, -1)
    if effusion_share > 0:
        paint(canvas, cavity, anatomy.FLUID, anatomy.EFFUSION)
    tissue = (anatomy.AERATED_LUNG - anatomy.AIR) / (1 - effusion_share)
    lung = anatomy.collapsed_lung(canvas.points, -1, effusion_share)
    paint(canvas, np.maximum(lung, cavity), anatomy.AIR + tissue, anatomy.LUNGS)


def _measured(
    hu: Float32[np.ndarray, "i j k"], noise_sd_hu: float, chance: np.random.Generator
) -> Int16[np.ndarray, "i j k"]:
    noise = chance.standard_normal(hu.shape, dtype=np.float32) * np.float32(noise_sd_hu)
    return np.rint(np.clip(hu + noise, -1024, HIGHEST_STORED_HU)).astype(np.int16)


def _slices(voxels: Int16[np.ndarray, "i j k"], patient_from_index: np.ndarray) -> list[Slice]:
    slices = []
    for k in range(voxels.shape[2]):
        patient_from_pixel = patient_from_index.copy()
        patient_from_pixel[:3, 2] = (0, 0, 1)
        patient_from_pixel[:3, 3] += k * patient_from_index[:3, 2]
        slices.append(Slice(voxels[:, :, k].T, patient_from_pixel, 1, "CT", "HU"))
    return slices
