"""How far every cell is from the walls of the free space."""

from dataclasses import replace

import numpy as np

from nodes.environment.distances import distance_to_faces
from nodes.geometry.grids import LabelMap, Volume, spacing_mm


def measure_distance(occupancy_grid: LabelMap) -> Volume:
    """Measure the signed distance from each cell's centre to the surface of the free space.

    In a free cell it is the clearance of its centre: the exact distance to the nearest point of any
    obstacle cell's box, positive. In an obstacle cell it is minus the distance to the nearest box
    that is free. The next cell over a face is half a cell away. Beyond the grid all is obstacle,
    and parts that were not chosen are obstacle, too. Between cell centres the distance changes by
    no more than the way between them.

    Parameters
    ----------
    occupancy_grid : with "free" cells, as build_occupancy_grid makes it.

    Returns
    -------
    float32 distances on the same grid, mm.
    """
    free = occupancy_grid.mask("free")
    distance = distance_to_faces(free, spacing_mm(occupancy_grid.patient_from_index))
    np.negative(distance, out=distance, where=~free)
    told = occupancy_grid.origin
    origin = replace(told, source=f"signed distance to the walls of {told.source}")
    return Volume(distance, occupancy_grid.patient_from_index, "mm", origin)
