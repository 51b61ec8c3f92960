"""The person's hand in a segmentation: barriers, corrections, and labels of their own."""

import numpy as np
from jaxtyping import Bool, Float, UInt8

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume
from nodes.imaging.ct_parameters import Ball, Correction, Disc, Solid
from nodes.imaging.ct_scan import Box, CtScan, Mask, Turn, box_around, points_of
from nodes.imaging.hand_labels import check_given_labels

BACKGROUND = "background"


def barrier_mask(
    shape: tuple[int, ...],
    patient_from_index: Float[np.ndarray, "4 4"],
    barriers: tuple[Solid, ...],
) -> Bool[np.ndarray, "x y z"]:
    """Return where no region may grow.

    Raises
    ------
    BadInput for a barrier that holds no voxel of the image.
    """
    closed = np.zeros(shape, bool)
    for number, solid in enumerate(barriers, start=1):
        box, inside = _voxels_in(solid, shape, patient_from_index, f"barrier {number}")
        closed[box] |= inside
    return closed


def paint_corrections(
    labels: UInt8[np.ndarray, "x y z"],
    patient_from_index: Float[np.ndarray, "4 4"],
    names: tuple[str, ...],
    corrections: tuple[Correction, ...],
) -> None:
    """Paint each correction over the labels, in their order.

    Raises
    ------
    BadInput for a label that the map does not have, or a solid outside of the image.
    """
    for number, correction in enumerate(corrections, start=1):
        if correction.label not in (*names, BACKGROUND):
            raise BadInput(
                f"correction {number}: label {correction.label}",
                f"it is one of {', '.join(names)}, or {BACKGROUND}",
                "mend the name, or add the label to `labels`",
            )
        value = 0 if correction.label == BACKGROUND else names.index(correction.label) + 1
        where = f"correction {number} ({correction.label})"
        box, inside = _voxels_in(correction.within, labels.shape, patient_from_index, where)
        labels[box][inside] = value


def _voxels_in(
    solid: Solid, shape: tuple[int, ...], patient_from_index: Float[np.ndarray, "4 4"], where: str
) -> tuple[Box, Bool[np.ndarray, "_ _ _"]]:
    """Return the part of the grid around a solid, and which of its voxels' centres are inside."""
    low, high = _extent(solid)
    box = box_around(shape, patient_from_index, low, high)
    inside = _is_inside(solid, points_of(shape, patient_from_index, box))
    if not inside.any():
        raise BadInput(
            f"{where}: {solid.shape} from {_words(low)} to {_words(high)}",
            "it holds the centre of at least one voxel of the image; patient LPS mm",
            "move it into the image, or make it larger than a voxel",
        )
    return box, inside


def _extent(solid: Solid) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    if isinstance(solid, (Ball, Disc)):
        reach = solid.radius_mm + (solid.thickness_mm if isinstance(solid, Disc) else 0.0)
        centre = np.array(solid.centre_patient_mm)
        return centre - reach, centre + reach
    return np.array(solid.lowest_patient_mm), np.array(solid.highest_patient_mm)


def _is_inside(solid: Solid, points: list[Float[np.ndarray, "_ _ _"]]) -> Bool[np.ndarray, "_ _ _"]:
    if isinstance(solid, (Ball, Disc)):
        offsets = [p - c for p, c in zip(points, solid.centre_patient_mm, strict=True)]
        near = sum(o * o for o in offsets) <= solid.radius_mm**2
        if isinstance(solid, Ball):
            return near
        normal = np.array(solid.normal_patient) / np.linalg.norm(solid.normal_patient)
        height = sum(o * n for o, n in zip(offsets, normal, strict=True))
        across = sum(o * o for o in offsets) - height * height
        return (abs(height) <= solid.thickness_mm / 2) & (across <= solid.radius_mm**2)
    ends = zip(points, solid.lowest_patient_mm, solid.highest_patient_mm, strict=True)
    return np.logical_and.reduce([(p >= low) & (p <= high) for p, low, high in ends])


def _words(point: Float[np.ndarray, "3"]) -> str:
    return "[" + ", ".join(f"{value:.1f}" for value in point) + "]"


def given_masks(given: LabelMap, ct: Volume, turn: Turn) -> dict[str, Mask]:
    """Return the labels that a person has drawn, along the patient's axes; of no names, nothing.

    Raises
    ------
    BadInput where they cannot be laid over the CT.
    """
    if not given.names or not given.voxels.any():
        return {}
    check_given_labels(ct, given)
    drawn = {name: given.mask(name) for name in given.names}
    return {name: turn.forth(mask) for name, mask in drawn.items() if mask.any()}


def without_given(scan: CtScan, given: dict[str, Mask]) -> CtScan:
    """Return the scan closed, besides its barriers, to all growth into what a person has drawn.

    A given body is no obstacle: all grows inside of it.
    """
    closed = scan.closed.copy()
    for name, mask in given.items():
        if name != "body":
            closed |= mask
    return scan._replace(closed=closed)
