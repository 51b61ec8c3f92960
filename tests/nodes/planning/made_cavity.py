"""A made chest: a box of fluid behind a wall with ribs, and entries between them."""

import numpy as np
import pandas

from nodes.environment.build_occupancy_grid import build_occupancy_grid
from nodes.environment.measure_distance import measure_distance
from nodes.environment.parameters import BuildOccupancyGridParameters
from nodes.geometry.grids import LabelMap
from nodes.geometry.origin import Origin

NAMES = ("body", "bone", "effusion", "lung")
BODY, BONE, EFFUSION, LUNG = 1, 2, 3, 4
VOXEL = 2.0
SHIFT = np.array([-40.0, 30.0, 10.0])
TURN = np.diag([1.0, 1.0, 1.0])
TINY = LabelMap(np.zeros((1, 1, 1), np.uint8), np.eye(4), NAMES, Origin("test", simulated=True))


def matrix(shift=SHIFT):
    patient_from_index = np.diag([VOXEL, VOXEL, VOXEL, 1.0])
    patient_from_index[:3, 3] = shift
    return patient_from_index


def chest(parts=1):
    """Air, a wall of 12 voxels all round with ribs along z in front and behind, fluid inside.

    Fluid is at 12 <= i < 48, j < 42, k < 52 voxels; two parts are parted by a wall of lung in i.
    """
    voxels = np.zeros((60, 54, 64), np.uint8)
    voxels[2:-2, 2:-2, 2:-2] = BODY
    voxels[12:48, 12:42, 12:52] = EFFUSION
    for i in range(5, 58, 14):
        for j in (6, 46):
            voxels[i : i + 3, j : j + 3, 2:-2] = BONE
    if parts == 2:
        voxels[36:40, 12:42, 12:52] = LUNG
    return LabelMap(voxels, matrix(), NAMES, Origin("test", simulated=True))


def occupancy(label_map, cell=VOXEL, **changed):
    values = {
        "free_labels": ("effusion",), "apart": (), "voxel_size_mm": cell, "neighbourhood": "faces",
        "inside_patient_mm": (), "smallest_part_ml": 0.1, "volume_tolerance": 0.1,
    }  # fmt: skip
    chosen = BuildOccupancyGridParameters(**{**values, **changed})
    grid = build_occupancy_grid(label_map, chosen)[0]
    return grid, measure_distance(grid)


def place(i, j, k):
    """Patient mm of a place in voxels of the chest."""
    return matrix()[:3, :3] @ np.array([i, j, k], float) + matrix()[:3, 3]


def entry_table(rows, part="free"):
    """Entries at places in voxels, along directions."""
    table = []
    for number, (voxel, direction) in enumerate(rows, start=1):
        point, way = place(*voxel), np.array(direction) / np.linalg.norm(direction)
        row = {"number": number, "window": 1, "part": part}
        row |= {f"skin_{axis}_mm": p for axis, p in zip("xyz", point - 20 * way, strict=True)}
        row |= {f"pleura_{axis}_mm": p for axis, p in zip("xyz", point, strict=True)}
        row |= {f"direction_{axis}": w for axis, w in zip("xyz", way, strict=True)}
        row |= {"wall_thickness_mm": 20.0, "bone_clearance_mm": 5.0, "tilt_deg": 0.0}
        table.append(row | {"side": "left", "face": "front"})
    columns = (
        "number window part skin_x_mm skin_y_mm skin_z_mm pleura_x_mm pleura_y_mm pleura_z_mm"
        " direction_x direction_y direction_z wall_thickness_mm bone_clearance_mm tilt_deg side"
        " face"
    )
    return pandas.DataFrame(table, columns=columns.split())


FRONT = [((20, 11.5, 20), (0, 1, 0)), ((29, 11.5, 40), (0, 1, 0)), ((40, 11.5, 24), (0, 1, 0))]
SIDES = [((11.5, 26, 30), (1, 0, 0)), ((47.5, 30, 20), (-1, 0, 0)), ((30, 26, 51.5), (0, 0, -1))]
ENTRIES = FRONT + SIDES
