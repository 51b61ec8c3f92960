"""How large each label is and in how many parts."""

from typing import TYPE_CHECKING

from nodes.geometry.grids import LabelMap, voxel_volume_mm3
from nodes.geometry.masks import bounding_box, connected_parts

if TYPE_CHECKING:
    import pandas

ML_IN_MM3 = 1000.0


def measure_labels(label_map: LabelMap) -> "pandas.DataFrame":
    """Measure each label.

    Parameters
    ----------
    label_map : labels on a grid.

    Returns
    -------
    One row a label: `label`, `volume_ml` (voxels times voxel volume), `parts` (connected over
    faces; 0 for a label that is nowhere).
    """
    import pandas

    voxel_ml = voxel_volume_mm3(label_map.patient_from_index) / ML_IN_MM3
    rows = []
    for name in label_map.names:
        mask = label_map.mask(name)
        _, sizes = connected_parts(mask[bounding_box(mask)])
        rows.append((name, float(sizes.sum() * voxel_ml), len(sizes)))
    return pandas.DataFrame(rows, columns=["label", "volume_ml", "parts"])
