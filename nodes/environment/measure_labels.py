"""How large each label is, in how many parts, and how large its surface is."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool

from nodes.environment.parameters import MeasureLabelsParameters
from nodes.geometry.closed_surfaces import surface_area_mm2
from nodes.geometry.grids import LabelMap, voxel_volume_mm3
from nodes.geometry.masks import bounding_box, connected_parts
from nodes.geometry.meshes import Surfaces

if TYPE_CHECKING:
    import pandas

ML_IN_MM3, CM2_IN_MM2 = 1000.0, 100.0
COLUMNS = ("label", "volume_ml", "surface_area_cm2", "parts", "largest_part_share")


def measure_labels(
    label_map: LabelMap, surfaces: Surfaces, parameters: MeasureLabelsParameters
) -> "pandas.DataFrame":
    """Measure each label, and groups of labels together.

    Parameters
    ----------
    label_map : labels on a grid.
    surfaces : of the same labels.
    parameters : which labels are also measured together.

    Returns
    -------
    One row a label, then one a group of which a label is there: `label`, `volume_ml` (voxels times
    voxel volume), `surface_area_cm2` (of the closed surface; for a label that reaches the skin the
    skin's; missing where there is none, and for groups), `parts` (connected over faces; 0 for a
    label that is nowhere), `largest_part_share` (of the volume; missing for an empty label).
    """
    import pandas

    areas = {name: surface_area_mm2(mesh) / CM2_IN_MM2 for name, mesh in surfaces.meshes}
    voxel_ml = voxel_volume_mm3(label_map.patient_from_index) / ML_IN_MM3
    rows = []
    for name, mask in _masks(label_map, parameters):
        _, sizes = connected_parts(mask[bounding_box(mask)])
        share = sizes.max() / sizes.sum() if len(sizes) else np.nan
        area = areas.get(name, np.nan)
        rows.append((name, float(sizes.sum() * voxel_ml), area, len(sizes), float(share)))
    return pandas.DataFrame(rows, columns=list(COLUMNS))


def _masks(
    label_map: LabelMap, parameters: MeasureLabelsParameters
) -> Iterator[tuple[str, Bool[np.ndarray, "i j k"]]]:
    for name in label_map.names:
        yield name, label_map.mask(name)
    for group, members in parameters.groups.items():
        numbers = [label_map.names.index(name) + 1 for name in members if name in label_map.names]
        if numbers and group not in label_map.names:
            yield group, np.isin(label_map.voxels, numbers)
