"""Labels that a person drew elsewhere and hands in; they win over what is found."""

from dataclasses import replace

import numpy as np

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.regridding import Grid, same_grid

# Corners of one grid in two files lie apart by rounding only, in voxels.
GRID_ROUNDING = 0.01
MOST_LABELS = 255  # of 8 bits


def check_given_labels(volume: Volume, given: LabelMap) -> None:
    """Refuse labels that do not lie on the volume's grid, or have no name or one name twice.

    Parameters
    ----------
    volume : the image that the labels were drawn in.
    given : the labels; no names mean that nothing is given, and then any grid will do.

    Raises
    ------
    BadInput where the labels cannot be laid over the image.
    """
    if not given.names:
        return
    grids = [Grid(image.patient_from_index, image.voxels.shape) for image in (volume, given)]
    if not same_grid(*grids, GRID_ROUNDING):
        raise BadInput(
            f"labels on {_written(given)} for an image of {_written(volume)}",
            f"given labels lie on the image's grid, to {GRID_ROUNDING:g} of a voxel",
            "draw them in this image, or resample them to its grid",
        )
    if len(set(given.names)) < len(given.names):
        raise BadInput(
            f"given labels {', '.join(given.names)}",
            "each label has a name of its own",
            "rename or join the labels that share a name",
        )
    highest = int(given.voxels.max(initial=0))
    if highest > len(given.names):
        raise BadInput(
            f"label value {highest} where {len(given.names)} labels have names",
            "each label value above 0 has a name",
            "name all labels of the given map",
        )


def _written(image: Volume | LabelMap) -> str:
    counts = " x ".join(map(str, image.voxels.shape))
    first = ", ".join(f"{place:.1f}" for place in image.patient_from_index[:3, 3])
    return f"{counts} voxels from ({first}) mm"


def replace_labels(found: LabelMap, given: LabelMap) -> LabelMap:
    """Lay given labels over found ones, on the same grid (see `check_given_labels`).

    A given label is exactly where the person drew it. What was found by the same name elsewhere
    becomes the first of the found labels, which stands for all else inside the skin. Names that
    were not found are kept as further labels.

    Parameters
    ----------
    found : labels of a segmentation, the first one "all else".
    given : the person's labels; no names mean that nothing is given.

    Returns
    -------
    The found labels in their order, then the further ones; the origin says what was given.

    Raises
    ------
    BadInput where together there are more labels than 8 bits can number.
    """
    if not given.names:
        return found
    names = found.names + tuple(name for name in given.names if name not in found.names)
    if len(names) > MOST_LABELS:
        raise BadInput(
            f"{len(names)} labels",
            f"a label map has {MOST_LABELS} labels at most",
            "hand in only the labels that are needed",
        )
    left = [0 if name in given.names else n for n, name in enumerate(found.names, start=1)]
    left = [number or left[0] for number in left]
    voxels = np.array([0, *left], np.uint8)[found.voxels]
    drawn = np.array([0, *(names.index(name) + 1 for name in given.names)], np.uint8)
    np.copyto(voxels, drawn[given.voxels], where=given.voxels > 0)
    origin = found.origin.with_notice(
        *given.origin.notices, f"drawn by hand and taken as given: {', '.join(given.names)}"
    )
    origin = replace(origin, simulated=origin.simulated or given.origin.simulated)
    return LabelMap(voxels, found.patient_from_index, names, origin)
