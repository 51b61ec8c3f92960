"""The connected parts of the free space: which one is meant, and how large each is."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, UInt8

from nodes.environment.parameters import BuildOccupancyGridParameters
from nodes.errors import BadInput
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap, spacing_mm, voxel_volume_mm3

if TYPE_CHECKING:
    import pandas

Parts = Int[np.ndarray, "a b c"]
Mask = Bool[np.ndarray, "a b c"]
Affine = Float[np.ndarray, "4 4"]

ML_IN_MM3, CM2_IN_MM2 = 1000.0, 100.0
SHARED = ("faces", "edges", "corners")
SMOOTH_CELLS, REACH = 1.0, 4  # width of a Gaussian, and where it has ended, cells
COLUMNS = ("name", "chosen", "volume_ml", "cells", "boundary_cells", "boundary_area_cm2",
           "centre_x_mm", "centre_y_mm", "centre_z_mm")  # fmt: skip


def choose_part(
    parts: Parts,
    sizes: Int[np.ndarray, " n"],
    patient_from_index: Affine,
    parameters: BuildOccupancyGridParameters,
) -> int:
    """Return the number of the part that holds the point of the parameters, or of the largest.

    Raises
    ------
    BadInput where the point is not in a part.
    """
    if not parameters.inside_patient_mm:
        return int(sizes.argmax()) + 1
    points = np.array(parameters.inside_patient_mm, float)
    cell = np.rint(transform_points(np.linalg.inv(patient_from_index), points)[0]).astype(int)
    inside = (cell >= 0).all() and (cell < parts.shape).all()
    number = int(parts[tuple(cell)]) if inside else 0
    if not number:
        raise BadInput(
            f"inside_patient_mm: {', '.join(f'{c:g}' for c in points[0])}",
            f"the point lies inside {' and '.join(parameters.free_labels)}, patient LPS mm",
            "read the coordinates off a viewer that shows patient LPS (in 3D Slicer, which shows"
            " RAS, turn the signs of the first two round)",
        )
    return number


def boundary_of(mask: Mask, neighbourhood: str) -> Mask:
    """Return the cells outside of a mask that share a face, edge or corner with one of it."""
    from scipy import ndimage

    reach = SHARED.index(neighbourhood) + 1
    return ndimage.binary_dilation(mask, ndimage.generate_binary_structure(3, reach)) & ~mask


def measure_parts(
    labels: UInt8[np.ndarray, "a b c"],
    share: Float32[np.ndarray, "a b c"],
    names: tuple[str, ...],
    patient_from_index: Affine,
    neighbourhood: str,
) -> "pandas.DataFrame":
    """Return one row for each free part, the chosen one first.

    Parameters
    ----------
    labels : cells of an occupancy grid.
    share : share of each cell that is inside the free labels.
    names : of the labels.
    patient_from_index : of the cells.
    neighbourhood : what boundary cells share with free ones.
    """
    import pandas
    from scipy import ndimage

    cell_ml = voxel_volume_mm3(patient_from_index) / ML_IN_MM3
    obstacle = (labels == 0) | (labels == names.index("boundary") + 1)
    rows = []
    for number, (name, tight) in enumerate(
        zip(names, ndimage.find_objects(labels, len(names)), strict=True), start=1
    ):
        if name == "boundary":
            continue
        box = tuple(slice(max(side.start - REACH, 0), side.stop + REACH) for side in tight)
        part = labels[box] == number
        cells = np.count_nonzero(part)
        centre = np.array(ndimage.center_of_mass(part)) + [side.start for side in box]
        x, y, z = transform_points(patient_from_index, centre[None])[0].tolist()
        boundary = np.count_nonzero(boundary_of(part, neighbourhood) & obstacle[box])
        area_cm2 = _area_mm2(part, share[box], spacing_mm(patient_from_index)) / CM2_IN_MM2
        rows.append((name, name == "free", cells * cell_ml, cells, boundary, area_cm2, x, y, z))
    return pandas.DataFrame(rows, columns=list(COLUMNS))


def main_labels(
    labels: UInt8[np.ndarray, "a b c"],
    names: tuple[str, ...],
    patient_from_index: Affine,
    label_map: LabelMap,
    free_labels: tuple[str, ...],
) -> list[str]:
    """Return for each free part, in order, the free label in which most of its cells' centres lie.

    Parameters
    ----------
    labels : cells of an occupancy grid.
    names : of its labels.
    patient_from_index : of the cells, whose axes are those of the label map.
    label_map : anatomy from which the grid is made.
    free_labels : names of the labels of which parts are made.
    """
    index_from_cell = np.linalg.inv(label_map.patient_from_index) @ patient_from_index
    places = [
        np.clip(np.rint(np.arange(n) * index_from_cell[a, a] + index_from_cell[a, 3]), 0, most - 1)
        for a, (n, most) in enumerate(zip(labels.shape, label_map.voxels.shape, strict=True))
    ]
    at_cells = label_map.voxels[np.ix_(*(place.astype(int) for place in places))]
    counts = np.bincount((labels.astype(np.uint16) * 256 + at_cells).ravel(), minlength=256 * 256)
    of_free = counts.reshape(256, 256)[:, [label_map.names.index(n) + 1 for n in free_labels]]
    numbers = [n for n, name in enumerate(names, start=1) if name != "boundary"]
    return [free_labels[int(n)] for n in of_free[numbers].argmax(axis=1)]


def _area_mm2(
    part: Mask, share: Float32[np.ndarray, "a b c"], spacing: Float[np.ndarray, "3"]
) -> float:
    """Return the area of a part's smooth boundary: the steepness of its smoothed shape, summed.

    Along any line out of the part the steepness adds up to 1, so over space it adds up to the area.
    """
    from scipy import ndimage

    shape = np.where(ndimage.binary_dilation(part), share, np.float32(0))
    shape = np.pad(shape, REACH)
    slopes = [
        ndimage.gaussian_filter(shape, SMOOTH_CELLS, order) / step
        for order, step in zip(((1, 0, 0), (0, 1, 0), (0, 0, 1)), spacing, strict=True)
    ]
    steepness = np.sqrt(sum(slope * slope for slope in slopes))
    return float(steepness.sum(dtype=float) * spacing.prod())
