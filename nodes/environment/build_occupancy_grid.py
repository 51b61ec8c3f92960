"""Where the robot may move: free cells, and the obstacle cells that bound them."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, UInt8

from nodes.environment.apart import free_pairs, wall_between
from nodes.environment.free_parts import (
    SHARED,
    boundary_of,
    choose_part,
    main_labels,
    measure_parts,
)
from nodes.environment.parameters import BuildOccupancyGridParameters
from nodes.environment.resampling import resample_mask
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, voxel_volume_mm3
from nodes.geometry.masks import connected_parts
from nodes.geometry.origin import Origin

if TYPE_CHECKING:
    import pandas

FREE, BOUNDARY, FIRST_OTHER = 1, 2, 3
MOST_OTHERS = 250  # labels are bytes
ML_IN_MM3 = 1000.0
HALF = 0.5  # of a cell: with as much inside it is free


def build_occupancy_grid(
    label_map: LabelMap, parameters: BuildOccupancyGridParameters
) -> tuple[LabelMap, "pandas.DataFrame"]:
    """Build S_free and S_bound of [Kuntz2017] Sec. IV-A on cubic cells; all else is S_obs.

    A cell is free where at least half of it is inside the free labels. Free cells are connected
    over faces: a robot cannot pass through an edge or a corner. Where labels that never communicate
    touch, the cells on both sides are obstacle. S_free is the largest part, or the one that holds
    the given point; S_bound are the obstacle cells next to it. The grid reaches two cells beyond
    the labels, so S_bound is closed; beyond the grid all is obstacle.

    Parameters
    ----------
    label_map : anatomy.
    parameters : the free labels and which of them are apart, the size of the cells, what is next to
        a cell, which part.

    Returns
    -------
    occupancy_grid : "free", "boundary", further free parts by size as "part_2", "part_3", ...
        (where one touches S_free over an edge, its cells stay its own), 0 for obstacle cells.
    parts_table : one row a free part: `name`, `label` (the one that most of it is), `chosen`,
        `volume_ml`, `cells`, `boundary_cells`, `boundary_area_cm2`, `centre_x_mm`, `centre_y_mm`,
        `centre_z_mm` (patient LPS).

    Raises
    ------
    BadInput where a label is unknown, the labels are too small for one cell, or the point is not
    in a part.
    """
    mask = _free_mask(label_map, parameters.free_labels)
    share, patient_from_index = resample_mask(
        mask, label_map.patient_from_index, parameters.voxel_size_mm
    )
    share, wall_notices = _keep_apart(share, mask, label_map, patient_from_index, parameters)
    parts, sizes = connected_parts(share >= HALF)
    if not len(sizes):
        raise _too_small(parameters.free_labels)
    chosen = choose_part(parts, sizes, patient_from_index, parameters)
    cell_ml = voxel_volume_mm3(patient_from_index) / ML_IN_MM3
    numbers = _numbers_by_size(sizes, chosen, parameters.smallest_part_ml / cell_ml)
    labels, names = _label_cells(parts, numbers, parameters.neighbourhood)
    table = measure_parts(labels, share, names, patient_from_index, parameters.neighbourhood)
    of_parts = main_labels(labels, names, patient_from_index, label_map, parameters.free_labels)
    table.insert(1, "label", of_parts)
    notices = [
        *wall_notices,
        *_grid_notices(mask, parameters, len(numbers)),
        *_volume_notices(mask, label_map, sizes * cell_ml, numbers, parameters),
    ]
    source = f"{' and '.join(parameters.free_labels)} of {label_map.origin.source}"
    origin = Origin(source, label_map.origin.simulated, label_map.origin.notices)
    grid = LabelMap(labels, patient_from_index, names, origin.with_notice(*notices))
    return grid, table


def _free_mask(label_map: LabelMap, wanted: tuple[str, ...]) -> Bool[np.ndarray, "i j k"]:
    for name in wanted:
        if name not in label_map.names:
            raise BadInput(
                f"free_labels: {name}",
                f"the label map has the labels {', '.join(label_map.names)}",
                "set free_labels to some of them",
            )
    numbers = [label_map.names.index(name) + 1 for name in wanted]
    mask = np.isin(label_map.voxels, numbers)
    if not mask.any():
        raise _too_small(wanted)
    return mask


def _keep_apart(
    share: Float32[np.ndarray, "a b c"],
    mask: Bool[np.ndarray, "i j k"],
    label_map: LabelMap,
    patient_from_index: Float[np.ndarray, "4 4"],
    parameters: BuildOccupancyGridParameters,
) -> tuple[Float32[np.ndarray, "a b c"], list[str]]:
    """Empty the cells between labels that never communicate, and say how much that is."""
    cell_ml = voxel_volume_mm3(patient_from_index) / ML_IN_MM3
    free, wall, notices = share >= HALF, np.zeros(share.shape, bool), []
    for pair in free_pairs(parameters):
        between = wall_between(pair, label_map, mask, free, parameters.voxel_size_mm)
        cells = np.count_nonzero(between)
        if cells:
            notices.append(f"{pair[0]} and {pair[1]} touch: {cells} cells between them"
                           f" ({cells * cell_ml:.3g} ml) are a wall")  # fmt: skip
        wall |= between
    return np.where(wall, np.float32(0), share), notices


def _numbers_by_size(sizes: Int[np.ndarray, " n"], chosen: int, smallest_cells: float) -> list[int]:
    """Return the numbers of the parts that are kept: the chosen one, then the others by size."""
    order = [int(n) + 1 for n in np.argsort(-sizes, kind="stable")]
    others = [n for n in order if n != chosen and sizes[n - 1] >= smallest_cells]
    return [chosen, *others[:MOST_OTHERS]]


def _label_cells(
    parts: Int[np.ndarray, "a b c"], numbers: list[int], neighbourhood: str
) -> tuple[UInt8[np.ndarray, "a b c"], tuple[str, ...]]:
    label_of = np.zeros(parts.max() + 1, np.uint8)
    label_of[numbers[1:]] = FIRST_OTHER + np.arange(len(numbers) - 1)
    labels = label_of[parts]
    free = parts == numbers[0]
    labels[boundary_of(free, neighbourhood) & (labels == 0)] = BOUNDARY
    labels[free] = FREE
    return labels, ("free", "boundary", *(f"part_{n}" for n in range(2, len(numbers) + 1)))


def _grid_notices(
    mask: Bool[np.ndarray, "i j k"], parameters: BuildOccupancyGridParameters, count: int
) -> list[str]:
    shared = SHARED.index(parameters.neighbourhood)
    how = ("a face", "a face or an edge", "a face, an edge or a corner")[shared]
    notices = [
        f"boundary cells are obstacle cells that share {how} with a free cell"
        f" ({(6, 18, 26)[shared]} neighbours)"
    ]
    if count > 1:
        notices.append(f"the free labels fall into {count} parts; the robot moves in one of them,"
                       " the others are obstacle")  # fmt: skip
    sides = [np.moveaxis(mask, axis, 0)[end] for axis in range(3) for end in (0, -1)]
    if any(side.any() for side in sides):
        names = " and ".join(parameters.free_labels)
        notices.append(f"{names} reaches the edge of the image: the free space is closed there")
    return notices


def _volume_notices(
    mask: Bool[np.ndarray, "i j k"],
    label_map: LabelMap,
    volumes_ml: Float[np.ndarray, " n"],
    numbers: list[int],
    parameters: BuildOccupancyGridParameters,
) -> list[str]:
    """Say what was dropped, and where cells hold clearly more or less than the labels."""
    notices = []
    dropped_ml = volumes_ml.sum() - volumes_ml[np.array(numbers) - 1].sum()
    if len(volumes_ml) > len(numbers):
        notices.append(f"{len(volumes_ml) - len(numbers)} small parts of the free labels count as"
                       f" obstacle ({dropped_ml:.3g} ml)")  # fmt: skip
    label_ml = np.count_nonzero(mask) * voxel_volume_mm3(label_map.patient_from_index) / ML_IN_MM3
    difference = volumes_ml.sum() / label_ml - 1
    if abs(difference) > parameters.volume_tolerance:
        notices.append(f"cells of {parameters.voxel_size_mm:g} mm hold {abs(difference):.0%}"
                       f" {'more' if difference > 0 else 'less'} than the free labels")  # fmt: skip
    return notices


def _too_small(names: tuple[str, ...]) -> BadInput:
    return BadInput(
        f"label {' and '.join(names)} holds no free cell",
        "the free labels fill at least half of one cell",
        "choose other free_labels, a smaller voxel_size_mm, or correct the segmentation",
    )
