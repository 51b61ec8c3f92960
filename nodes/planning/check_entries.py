"""Whether entry points that a person chose lie where needles reach the free space."""

import numpy as np
from jaxtyping import Bool, Float

from nodes.errors import BadInput
from nodes.geometry.frames import transform_points
from nodes.geometry.grids import LabelMap, spacing_mm, voxel_volume_mm3
from nodes.planning.artefacts import PlacedSetup
from nodes.planning.surface_cells import beside

Point = Float[np.ndarray, "3"]

ML_IN_MM3 = 1000.0
FREE, BOUNDARY = "free", "boundary"


def check_entries(
    placed: PlacedSetup,
    label_map: LabelMap,
    occupancy_grid: LabelMap,
    bones: tuple[str, ...],
    sheath_mm: float,
) -> None:
    """Refuse entry points that are not at the wall of the free space.

    Parameters
    ----------
    bones : labels that no needle passes.
    sheath_mm : how far from the free space, and from its wall, an entry point may be.

    Raises
    ------
    BadInput with the needle and where its entry point is.
    """
    for needle, point in enumerate(placed.setup.entry_points_patient_mm):
        where = f"{placed.name}: entry_points_patient_mm[{needle}] = {written(point)} mm"
        label = _label_at(label_map, point)
        if label is None:
            raise BadInput(
                f"{where} lies beyond the image",
                "an entry point lies in the image, patient LPS mm",
                "read the coordinates off a viewer that shows patient LPS (in 3D Slicer, which"
                " shows RAS, turn the signs of the first two round)",
            )
        if label in bones:
            raise BadInput(
                f"{where} lies in {label}",
                f"no needle passes {' or '.join(bones)}",
                "choose a row of the table of entries, whose needles pass between ribs",
            )
        _check_part(where, label, point, occupancy_grid, sheath_mm)


def _check_part(where: str, label: str, point: Point, grid: LabelMap, sheath_mm: float) -> None:
    free = grid.mask(FREE)
    away = distance_to_cells(free, grid, point)
    rule = (
        f"an entry point is where a needle reaches the free space: at most sheath_mm ="
        f" {sheath_mm:g} mm from it, and from its wall"
    )
    if away > sheath_mm:
        near = _nearest_part(grid, point, sheath_mm)
        if near:
            raise BadInput(
                f"{where} leads into {near}, {_volume(grid, near):.3g} ml of the free labels that"
                f' are apart from "{FREE}", {_volume(grid, FREE):.3g} ml, which is {away:.1f} mm'
                " away",
                f'the free space is in several parts; robots move in the one named "{FREE}"',
                "set inside_patient_mm of the occupancy grid to a point in the part that is meant,"
                f' or enter into "{FREE}"',
            )
        raise BadInput(
            f"{where} lies in {label}, {away:.1f} mm from the free space",
            rule,
            "choose the pleura point of a row of the table of entries, or move it to the wall's"
            " inner side",
        )
    depth = min(distance_to_cells(~free, grid, point), _depth_in_grid(grid, point))
    if depth > sheath_mm:
        raise BadInput(
            f"{where} lies inside of the free space, {depth:.1f} mm from its wall",
            rule,
            "move it to where the needle comes out of the wall",
        )


def _label_at(label_map: LabelMap, point: Point) -> str | None:
    index = transform_points(np.linalg.inv(label_map.patient_from_index), point[None])[0]
    voxel = np.rint(index).astype(int)
    if (voxel < 0).any() or (voxel >= label_map.voxels.shape).any():
        return None
    number = int(label_map.voxels[tuple(voxel)])
    return label_map.names[number - 1] if number else "no label"


def distance_to_cells(mask: Bool[np.ndarray, "i j k"], grid: LabelMap, point: Point) -> float:
    """Return the distance from a point to the nearest box of a cell of the mask, mm."""
    index = transform_points(np.linalg.inv(grid.patient_from_index), point[None])[0]
    cell = np.rint(index).astype(int)
    if (cell >= 0).all() and (cell < mask.shape).all() and mask[tuple(cell)]:
        return 0.0
    cells = np.argwhere(mask & beside(~mask))  # the nearest box is one of these, or is cut off by
    edge = np.argwhere(_at_edge(mask))  # the grid's edge
    gaps = np.maximum(abs(np.concatenate([cells, edge]) - index) - 0.5, 0)
    lengths = np.linalg.norm(gaps * spacing_mm(grid.patient_from_index), axis=1)
    return float(lengths.min(initial=np.inf))


def _at_edge(mask: Bool[np.ndarray, "i j k"]) -> Bool[np.ndarray, "i j k"]:
    edge = mask.copy()
    edge[1:-1, 1:-1, 1:-1] = False
    return edge


def _depth_in_grid(grid: LabelMap, point: Point) -> float:
    """Return the distance from a point within the grid to all that is beyond it, mm."""
    index = transform_points(np.linalg.inv(grid.patient_from_index), point[None])[0]
    below, above = index + 0.5, np.array(grid.voxels.shape) - 0.5 - index
    return float((np.minimum(below, above) * spacing_mm(grid.patient_from_index)).min())


def _nearest_part(grid: LabelMap, point: Point, within_mm: float) -> str:
    """Return the name of the part of the free labels that is nearest within a distance, or ""."""
    others = [name for name in grid.names if name not in (FREE, BOUNDARY)]
    distances = [distance_to_cells(grid.mask(name), grid, point) for name in others]
    near = [pair for pair in zip(distances, others, strict=True) if pair[0] <= within_mm]
    return min(near)[1] if near else ""


def _volume(grid: LabelMap, name: str) -> float:
    """Return the volume of a part, ml."""
    return np.count_nonzero(grid.mask(name)) * voxel_volume_mm3(grid.patient_from_index) / ML_IN_MM3


def written(numbers: Float[np.ndarray, " n"], digits: int = 1) -> str:
    """Return numbers as a person writes them in a list."""
    return "[" + ", ".join(f"{float(number):.{digits}f}" for number in numbers) + "]"
