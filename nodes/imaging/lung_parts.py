"""Which voxels of an old lung are collapsed lung, and which are the cavity that it leaves."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float32, UInt8

from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap, spacing_mm
from nodes.geometry.masks import (
    Mask,
    bounding_box,
    grow_mask,
    largest_part,
    plane_holes,
    shrink_mask,
)
from nodes.imaging.lung_deformation import Affine, Collapse, Region, coarsen
from nodes.imaging.parameters import CollapseLungParameters

MARGIN = 10  # coarse voxels around a lung that is closed; more than a vessel is wide
ROUNDS, CLOSE_ENOUGH = 16, 1e-3  # of setting the volume; parts of the old lung
DAMPING = 0.6  # of each round: pieces that join or part make the volume jump


@dataclass(frozen=True)
class Settled:
    """A collapsed lung on the grid.

    Parameters
    ----------
    lung : (i, j, k) its voxels.
    share : (n,) for each voxel of the old lung, in their order, the share that is lung now.
    """

    lung: Mask
    share: Float32[np.ndarray, " n"]


def whole_lung(label_map: LabelMap, name: str, parameters: CollapseLungParameters) -> Mask:
    """Return the largest part of a lung's label, with the bronchi and vessels in it."""
    lung = largest_part(label_map.mask(name))
    box = bounding_box(lung, 1)
    old, patient_from_index = lung[box], label_map.patient_from_index
    labels = label_map.voxels[box]
    tissue, airway = _any_of(label_map, labels, "body"), _any_of(label_map, labels, "airway")
    bronchi = _surrounded(airway, old, patient_from_index, parameters.widest_vessel_mm)
    walls = grow_mask(bronchi, parameters.bronchial_wall_mm, spacing_mm(patient_from_index))
    vessels = _crossing(old, tissue | airway, patient_from_index, parameters.widest_vessel_mm)
    lung[box] |= bronchi | (walls & (tissue | airway)) | vessels
    return lung


def _any_of(label_map: LabelMap, labels: UInt8[np.ndarray, "i j k"], name: str) -> Mask:
    found = name in label_map.names
    return labels == label_map.names.index(name) + 1 if found else np.zeros(labels.shape, bool)


def _surrounded(airway: Mask, lung: Mask, patient_from_index: Affine, widest_mm: float) -> Mask:
    """Return the airway that lies in gaps of the lung no wider than this."""
    region = coarsen(lung, patient_from_index, 0.0)
    step = spacing_mm(region.patient_from_coarse)
    wide = np.pad(region.inside, MARGIN)
    closed = shrink_mask(grow_mask(wide, widest_mm / 2, step), widest_mm / 2, step)
    closed = closed[MARGIN:-MARGIN, MARGIN:-MARGIN, MARGIN:-MARGIN]
    return _within(airway, closed, region.patient_from_coarse, patient_from_index)


def _crossing(lung: Mask, other: Mask, patient_from_index: Affine, widest_mm: float) -> Mask:
    """Return what the lung surrounds in a sagittal plane and is no wider than a vessel.

    At the hilum vessels and bronchi go into the mediastinum across such planes. Heart and liver
    are wider; their tips, which are not, are parts of what a ball of that width fits into.
    """
    holes = plane_holes(lung, sagittal_axis(patient_from_index)) & other
    holes = _narrow_parts(holes, patient_from_index, widest_mm)
    region = coarsen(other, patient_from_index, 0.0)
    step = spacing_mm(region.patient_from_coarse)
    organs = shrink_mask(region.inside, widest_mm / 2, step)
    organs = grow_mask(organs, widest_mm / 2 + float(step.max()), step)
    return holes & ~_within(holes, organs, region.patient_from_coarse, patient_from_index)


def _within(
    mask: Mask,
    coarse: Bool[np.ndarray, "_ _ _"],
    patient_from_coarse: Affine,
    patient_from_index: Affine,
) -> Mask:
    """Return the part of a mask that lies in another one on a coarse grid."""
    coarse_from_index = np.linalg.inv(patient_from_coarse) @ patient_from_index
    places = transform_points(coarse_from_index, np.argwhere(mask).astype(float))
    i, j, k = np.clip(np.rint(places).astype(int), 0, np.array(coarse.shape) - 1).T
    result = np.zeros_like(mask)
    result[mask] = coarse[i, j, k]
    return result


def sagittal_axis(patient_from_index: Affine) -> int:
    """Return the index axis that is closest to the patient's left-right axis."""
    return int(np.argmax(abs(patient_from_index[0, :3]) / spacing_mm(patient_from_index)))


def axial_axis(patient_from_index: Affine) -> int:
    """Return the index axis that is closest to the patient's long axis."""
    return int(np.argmax(abs(patient_from_index[2, :3]) / spacing_mm(patient_from_index)))


def _narrow_parts(holes: Mask, patient_from_index: Affine, widest_mm: float) -> Mask:
    """Return the holes whose area in their sagittal plane is at most that of a disc so wide."""
    from scipy import ndimage

    axis = sagittal_axis(patient_from_index)
    in_plane = ndimage.generate_binary_structure(3, 1)
    in_plane = np.moveaxis(in_plane, axis, 0)
    in_plane[[0, 2]] = False
    in_plane = np.moveaxis(in_plane, 0, axis)
    parts, count = ndimage.label(holes, in_plane)
    spacing = np.delete(spacing_mm(patient_from_index), axis)
    areas = np.bincount(parts.ravel(), minlength=count + 1) * spacing.prod()
    narrow = areas <= np.pi / 4 * widest_mm**2
    narrow[0] = False
    return narrow[parts]


def settle_lung(
    old: Mask,
    patient_from_index: Affine,
    region: Region,
    collapse: Collapse,
    parameters: CollapseLungParameters,
) -> Settled:
    """Return the collapsed lung: the voxels of the old one that belong to it most.

    As many as its share of the volume asks for. Lung that lies apart joins the cavity, and parts
    of the cavity that lie apart join the lung, so that each is in one piece; the number is then
    mended and all is tried again. A cavity as thin as the voxels may miss its share; the best is
    taken.
    """
    belonging = collapse.belonging(region, patient_from_index, old.shape)[old]
    wanted = round((1 - parameters.collapsed_share) * len(belonging))
    count = wanted
    best = (len(belonging) + 1, old, 0.0)
    for _ in range(ROUNDS):
        count = int(np.clip(count, 1, len(belonging) - 1))
        level = float(np.partition(belonging, -count)[-count])
        lung = _in_one_piece(old, belonging >= level)
        missing = wanted - int(np.count_nonzero(lung))
        if abs(missing) < best[0]:
            best = (abs(missing), lung, level)
        if best[0] <= CLOSE_ENOUGH * len(belonging):
            break
        count += round(missing * DAMPING)
    _, lung, level = best
    return Settled(lung, _edge(belonging, level, lung[old], patient_from_index, parameters))


def _in_one_piece(old: Mask, chosen: np.ndarray) -> Mask:
    lung = np.zeros_like(old)
    lung[old] = chosen
    lung = largest_part(lung)
    return old & ~largest_part(old & ~lung)


def _edge(
    belonging: Float32[np.ndarray, " n"],
    level: float,
    in_lung: np.ndarray,
    patient_from_index: Affine,
    parameters: CollapseLungParameters,
) -> Float32[np.ndarray, " n"]:
    """Return each voxel's share of lung, which goes from 1 to 0 over one voxel at the surface.

    Across a flat surface, smoothed by a normal distribution of width s, belonging falls by
    1 / (s sqrt(2 pi)) a millimetre.
    """
    voxel = float(np.cbrt(spacing_mm(patient_from_index).prod()))
    fall = voxel / (parameters.smoothing_mm * np.sqrt(2 * np.pi))
    share = np.clip(0.5 + (belonging - np.float32(level)) / np.float32(fall), 0, 1)
    return np.where((share >= 0.5) == in_lung, share, in_lung).astype(np.float32)
