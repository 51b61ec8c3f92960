"""Label files and parameters for tests, made by hand."""

import numpy as np

from nodes.geometry.grids import LabelMap
from nodes.geometry.label_files import FileLabels, LabelFiles
from nodes.geometry.origin import Origin
from nodes.imaging.parameters import CombineLabelMapsParameters, PlaceLabelsParameters

PLACE = {"names": {}, "order": [], "smallest_voxels": 1, "grid_tolerance_voxels": 0.01}
COMBINE = {**PLACE, "voxel_size_mm": 0.0, "margin_mm": 2.0, "most_voxels_million": 10.0}


def combine_parameters(**changed) -> CombineLabelMapsParameters:
    return CombineLabelMapsParameters(**{**COMBINE, **changed})


def place_parameters(**changed) -> PlaceLabelsParameters:
    return PlaceLabelsParameters(**{**PLACE, **changed})


def file_labels(voxels: np.ndarray, names: tuple[str, ...], matrix=None, origin=None) -> FileLabels:
    """What a file with these labels on this grid holds."""
    matrix = np.eye(4) if matrix is None else matrix
    filled = np.argwhere(voxels)
    corner, end = filled.min(axis=0), filled.max(axis=0) + 1
    content = voxels[tuple(map(slice, corner, end))].astype(np.uint8)
    start = matrix.copy()
    start[:3, 3] += matrix[:3, :3] @ corner
    origin = origin or Origin("label maps handed in")
    return FileLabels(
        LabelMap(content, start, names, origin), tuple(map(int, corner)), voxels.shape
    )


def mask_file(name: str, mask: np.ndarray, matrix=None) -> FileLabels:
    return file_labels(mask.astype(np.uint8), (name,), matrix)


def files(*maps: FileLabels, skipped: int = 0) -> LabelFiles:
    return LabelFiles(tuple(maps), skipped)


def block(shape, *sides: tuple[int, int]) -> np.ndarray:
    mask = np.zeros(shape, bool)
    mask[tuple(slice(*side) for side in sides)] = True
    return mask


def steps(*mm: float, start=(0.0, 0.0, 0.0)) -> np.ndarray:
    matrix = np.diag([*mm, 1.0])
    matrix[:3, 3] = start
    return matrix
