"""The air in trachea and bronchi: grown from the trachea with steps of the threshold.

Each step lets the region grow through slightly denser air. Where it breaks through a bronchus'
wall, the lung pours in: the volume jumps, and the step before is kept.
"""

import numpy as np
from jaxtyping import Int, Shaped

from nodes.errors import BadInput
from nodes.geometry.masks import bounding_box, connected_parts, grow_mask
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import Box, CtScan, Mask
from nodes.imaging.region_growing import grow_below, seeds_in_tissue

SOLID_HU = 3000  # of what no air grows through


def find_airway(scan: CtScan, body: Mask, parameters: SegmentCtParameters) -> Mask:
    """Return the air in the airway.

    Raises
    ------
    BadInput where no trachea is found, or the region leaks whatever the threshold.
    """
    seeds = seeds_in_tissue(
        scan,
        parameters.airway_seeds_patient_mm,
        (-2000.0, parameters.airway_wall_hu),
        "airway",
    )
    box = _middle_of(body, scan, seeds, parameters)
    air = _smoothed(scan, box, parameters.smoothing_mm)
    air[~body[box] | scan.closed[box]] = SOLID_HU
    offset = np.array([side.start for side in box])
    if not len(seeds):
        seeds = _trachea(air, scan, parameters) + offset
    core = _grown_by_steps(air, seeds - offset, scan, parameters)
    result = np.zeros_like(body)
    result[box] = _up_to_the_wall(scan, box, core, parameters) & body[box] & ~scan.closed[box]
    return result


def _middle_of(
    body: Mask, scan: CtScan, seeds: Int[np.ndarray, "n 3"], parameters: SegmentCtParameters
) -> Box:
    """Return the part of the body around its bones' middle, and around the seeds."""
    box = bounding_box(body)
    bright = (scan.hu[box] >= parameters.bone_threshold_hu) & body[box]
    columns = np.repeat(np.arange(bright.shape[0]), np.count_nonzero(bright, axis=(1, 2)))
    middle = float(np.median(columns)) if len(columns) else bright.shape[0] / 2
    reach = parameters.airway_reach_mm / float(scan.spacing[0])
    x = [box[0].start + middle, *seeds[:, 0]]
    start, stop = max(int(min(x) - reach), box[0].start), int(max(x) + reach) + 1
    return (slice(start, min(stop, body.shape[0])), box[1], box[2])


def _smoothed(scan: CtScan, box: Box, width_mm: float) -> Shaped[np.ndarray, "x y z"]:
    """Return a part of the scan, each voxel averaged with its neighbours (Gaussian), int16."""
    import SimpleITK as sitk

    image = sitk.GetImageFromArray(np.ascontiguousarray(scan.hu[box]))
    image.SetSpacing([float(step) for step in scan.spacing[::-1]])
    if width_mm > 0:
        image = sitk.SmoothingRecursiveGaussian(image, [width_mm] * 3)
    return sitk.GetArrayFromImage(sitk.Cast(image, sitk.sitkInt16))


def _trachea(
    air: Shaped[np.ndarray, "x y z"], scan: CtScan, parameters: SegmentCtParameters
) -> Int[np.ndarray, "n 3"]:
    """Return voxels on the axis of the trachea: the longest upright column of round air.

    Raises
    ------
    BadInput where no column is long enough.
    """
    from scipy import ndimage

    rounds = _round_air(air < parameters.trachea_threshold_hu, scan.spacing, parameters)
    parts, sizes = connected_parts(rounds)
    heights_mm = np.zeros(len(sizes) + 1)
    for number, place in enumerate(ndimage.find_objects(parts), start=1):
        heights_mm[number] = (place[2].stop - place[2].start) * float(scan.spacing[2])
    best, length = int(heights_mm.argmax()), float(heights_mm.max())
    if length < parameters.shortest_trachea_mm:
        raise BadInput(
            f"no trachea found: the longest column of round air is {length:.0f} mm long",
            f"round air below {parameters.trachea_threshold_hu:g} HU over"
            f" {parameters.shortest_trachea_mm:g} mm or more",
            "give a point in the trachea as airway_seeds_patient_mm, or take airway out of labels",
        )
    return np.argwhere(parts == best)


def _round_air(
    air: Mask, spacing_mm: Shaped[np.ndarray, "3"], parameters: SegmentCtParameters
) -> Mask:
    """Return, slice by slice, the parts of air that are as large and as round as a trachea."""
    from scipy import ndimage

    rounds = np.zeros_like(air)
    pixel = float(spacing_mm[0] * spacing_mm[1])
    for k in range(air.shape[2]):
        parts, count = ndimage.label(air[:, :, k])
        if not count:
            continue
        areas = np.bincount(parts.ravel())[1:] * pixel
        for number in np.flatnonzero(
            (areas >= parameters.smallest_trachea_mm2) & (areas <= parameters.largest_trachea_mm2)
        ):
            window = ndimage.find_objects(parts, max_label=number + 1)[number]
            sides = [(s.stop - s.start) * step for s, step in zip(window, spacing_mm, strict=False)]
            # A disc fills pi / 4 of the square around it.
            fills = areas[number] / max(sides) ** 2 / (np.pi / 4)
            if fills >= parameters.trachea_roundness:
                rounds[window[0], window[1], k] |= parts[window] == number + 1
    return rounds


def _grown_by_steps(
    air: Shaped[np.ndarray, "x y z"],
    seeds: Int[np.ndarray, "n 3"],
    scan: CtScan,
    parameters: SegmentCtParameters,
) -> Mask:
    """Return the last region before the volume jumps or exceeds an airway's."""
    values = air[tuple(seeds.T)]
    threshold = float(np.median(values)) + parameters.airway_step_hu
    if threshold >= parameters.airway_wall_hu:
        raise BadInput(
            f"air of {np.median(values):.0f} HU at the airway's seeds",
            f"it is at least airway_step_hu below airway_wall_hu, {parameters.airway_wall_hu:g} HU",
            "move airway_seeds_patient_mm into the trachea's middle",
        )
    kept, volume_ml = None, 0.0
    while threshold < parameters.airway_wall_hu:
        grown = grow_below(air, seeds, threshold)
        grown_ml = scan.millilitres(int(np.count_nonzero(grown)))
        jumped = kept is not None and grown_ml - volume_ml > parameters.airway_jump_ml
        if jumped or grown_ml > parameters.largest_airway_ml:
            break
        kept, volume_ml = grown, grown_ml
        threshold += parameters.airway_step_hu
    if kept is None:
        raise BadInput(
            f"the airway leaks into the lung: {grown_ml:.0f} ml below {threshold:.0f} HU",
            f"largest_airway_ml: an airway holds {parameters.largest_airway_ml:g} ml or less",
            "put a barrier where it leaks, move airway_seeds_patient_mm, or take smaller steps"
            " (airway_step_hu)",
        )
    return kept


def _up_to_the_wall(scan: CtScan, box: Box, core: Mask, parameters: SegmentCtParameters) -> Mask:
    """Return the core and the air around it, as far as the wall's brightest line.

    A thin wall is blurred and never reaches the half height between air and tissue; but it is a
    ridge between two valleys of air, and a watershed parts these.
    """
    from skimage.segmentation import watershed

    near = grow_mask(core, parameters.airway_wall_mm, scan.spacing)
    inner = bounding_box(near, 1)
    hu = scan.hu[box][inner]
    core, near = core[inner], near[inner]
    air = hu < parameters.airway_wall_hu
    markers = core.astype(np.int32)
    markers[air & ~near] = 2
    band = air & grow_mask(near, float(scan.spacing.max()), scan.spacing) | core
    result = np.zeros(scan.hu[box].shape, bool)
    result[inner] = watershed(hu, markers, mask=band) == 1
    return result
