"""Label maps that a person hands in, brought to the grid of an image."""

from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.label_files import LabelFiles
from nodes.geometry.regridding import Grid
from nodes.imaging.lay_labels import join_origins, lay_layers, name_layers
from nodes.imaging.parameters import PlaceLabelsParameters


def place_labels(
    label_files: LabelFiles, volume: Volume, parameters: PlaceLabelsParameters
) -> LabelMap:
    """Bring the label maps of a person's files to the grid of an image, one label a voxel.

    What resampling, the image's edge and overlaps changed is told in the notices.

    Parameters
    ----------
    label_files : any number of labels; none means that nothing is handed in.
    volume : the image, whose grid they go to.
    parameters : names, order.

    Returns
    -------
    All labels under our names, numbered in the order of the files; without label files no names,
    and 0 everywhere.

    Raises
    ------
    BadInput for names that no file has, for tiny labels, and for labels of which nothing is left,
    as those of another patient's image.
    """
    grid = Grid(volume.patient_from_index, volume.voxels.shape)
    layers = name_layers(label_files, parameters.names, parameters.smallest_voxels)
    voxels, notices = lay_layers(layers, parameters.order, grid, parameters.grid_tolerance_voxels)
    origin = join_origins(label_files, layers).with_notice(*notices)
    return LabelMap(voxels, volume.patient_from_index, tuple(layers), origin)
