"""Label maps on different grids brought to one."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, spacing_mm, voxel_volume_mm3
from nodes.geometry.label_files import FileLabels, LabelFiles
from nodes.geometry.regridding import Grid, index_extent, same_grid
from nodes.imaging.lay_labels import Part, join_origins, lay_layers, name_layers
from nodes.imaging.parameters import CombineLabelMapsParameters


def combine_label_maps(label_files: LabelFiles, parameters: CombineLabelMapsParameters) -> LabelMap:
    """Bring the label maps of a person's files to one grid, one label a voxel.

    Where all files share one grid, that grid is kept as it is. Otherwise the grid has the axes and
    the spacing of the finest file, or cubic voxels, and holds what all labels hold and a margin.
    What resampling and overlaps changed is told in the notices.

    Parameters
    ----------
    label_files : at least one label.
    parameters : names, order, grid.

    Returns
    -------
    All labels under our names, numbered in the order of the files.

    Raises
    ------
    BadInput where there is no label, for names that no file has, for tiny labels and labels of
    which nothing is left, and for a grid of too many voxels.
    """
    layers = name_layers(label_files, parameters.names, parameters.smallest_voxels)
    if not layers:
        raise BadInput("no labels", "there is at least one label to combine", "hand in label maps")
    grid = _common_grid(layers, parameters)
    voxels, notices = lay_layers(layers, parameters.order, grid, parameters.grid_tolerance_voxels)
    origin = join_origins(label_files, layers).with_notice(*notices)
    return LabelMap(voxels, grid.patient_from_index, tuple(layers), origin)


def _common_grid(
    layers: Mapping[str, Sequence[Part]], parameters: CombineLabelMapsParameters
) -> Grid:
    used = [part.labels for parts in layers.values() for part in parts]
    grids = [Grid(each.patient_from_grid, each.grid_shape) for each in used]
    tolerance = parameters.grid_tolerance_voxels
    if not parameters.voxel_size_mm and all(same_grid(grids[0], g, tolerance) for g in grids):
        return grids[0]
    matrix = _finest_lattice(used, parameters.voxel_size_mm)
    return _cut_to_content(used, matrix, parameters)


def _finest_lattice(used: Sequence[FileLabels], voxel_size_mm: float) -> Float[np.ndarray, "4 4"]:
    """Return the file grid with the smallest voxels, or its axes with cubic ones.

    Of equal ones the first by its numbers: the order of the files must not matter.
    """
    matrices = [each.patient_from_grid for each in used]
    matrix = min(matrices, key=lambda m: (round(voxel_volume_mm3(m), 9), *m.ravel()))
    if voxel_size_mm:
        matrix[:3, :3] *= voxel_size_mm / spacing_mm(matrix)
    return matrix


def _cut_to_content(
    used: Sequence[FileLabels],
    lattice: Float[np.ndarray, "4 4"],
    parameters: CombineLabelMapsParameters,
) -> Grid:
    """Return the part of a lattice that holds all content and the margin."""
    contents = [Grid(each.content.patient_from_index, each.content.voxels.shape) for each in used]
    extents = [index_extent(np.linalg.inv(lattice), content) for content in contents]
    margin = parameters.margin_mm / spacing_mm(lattice)
    # An extent's end lies half a voxel beyond the last centre; rounding must not add a voxel.
    low = np.ceil(np.min([low for low, _ in extents], axis=0) - margin - 1e-6).astype(int)
    high = np.floor(np.max([high for _, high in extents], axis=0) + margin + 1e-6).astype(int)
    shape = tuple(int(n) for n in high - low + 1)
    millions = float(np.prod(shape, dtype=float)) / 1e6
    if millions > parameters.most_voxels_million:
        raise BadInput(
            f"{' x '.join(map(str, shape))} = {millions:.0f} million voxels",
            f"the common grid has at most {parameters.most_voxels_million:g} million"
            " (most_voxels_million)",
            "set a larger voxel_size_mm, or leave the finest or the farthest label out with names",
        )
    matrix = lattice.copy()
    matrix[:3, 3] += lattice[:3, :3] @ low
    return Grid(matrix, shape)
