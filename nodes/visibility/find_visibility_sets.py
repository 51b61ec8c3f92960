"""What the cameras of CRISP robots see of the surface of the free space."""

from typing import TYPE_CHECKING

import numpy as np

from nodes.geometry.grids import LabelMap
from nodes.geometry.lines_of_sight import SurfaceCells, find_surface, look
from nodes.geometry.origin import Origin
from nodes.planning.artefacts import CrispTree, CrispTrees
from nodes.visibility.artefacts import VisibilitySet, VisibilitySets
from nodes.visibility.parameters import FindVisibilitySetsParameters

if TYPE_CHECKING:
    import pandas

UNION, HOUR_S = "union", 3600.0
CLEAR = "only anatomy hides: needles before the camera and turbid fluid are not counted"
MEANING = {
    "own ray": "a cell is seen if the straight way to its centre is free: a wall that is met at a"
    " grazing angle hides itself",
    "first hit": "a cell is seen if it is the first obstacle on the way to any cell's centre",
}


def find_visibility_sets(
    crisp_trees: CrispTrees, occupancy_grid: LabelMap, parameters: FindVisibilitySetsParameters
) -> tuple[VisibilitySets, "pandas.DataFrame"]:
    """Find which boundary cells are seen from every node of every tree, and from which first.

    A cell is seen within the camera's cone, as [Kuntz2017] Sec. IV-A and IV-C have it. Boundary
    cells that share no face with a free one are never seen, and count as cells all the same.

    Parameters
    ----------
    crisp_trees : one a set-up.
    occupancy_grid : that they were grown in.
    parameters : when a cell counts as seen.

    Returns
    -------
    visibility_sets : of all trees on one surface.
    visibility_table : one row a set-up and a last row "union": `name`, `share_seen`, `cells_seen`,
        `cells`, `nodes`, `seconds` (of growing; of the union the longest), `nodes_per_hour`.
    """
    surface = find_surface(occupancy_grid)
    looks = [_look_from(tree, surface, parameters) for tree in crisp_trees.trees]
    sets, blind = tuple(found for found, _ in looks), sum(count for _, count in looks)
    found = VisibilitySets(
        surface.cells,
        occupancy_grid.patient_from_index,
        occupancy_grid.voxels.shape,
        parameters.reading,
        sets,
        _tell(crisp_trees, occupancy_grid.origin, parameters, blind),
    )
    return found, _tabulate(sets, len(surface.cells))


def _look_from(
    tree: CrispTree, surface: SurfaceCells, parameters: FindVisibilitySetsParameters
) -> tuple[VisibilitySet, int]:
    """Return what a tree sees, and how many of its nodes have the camera outside of free cells."""
    first_nodes = np.full(len(surface.cells), -1, np.int64)
    cameras, views = tree.cameras_patient_mm, tree.views
    angle = tree.placed.setup.field_of_view_deg
    blind = look(surface, cameras, views, angle, parameters.reading, first_nodes)
    return VisibilitySet(tree.placed.name, first_nodes, tree.seconds), blind


def _tell(
    crisp_trees: CrispTrees, grid: Origin, parameters: FindVisibilitySetsParameters, blind: int
) -> Origin:
    told = crisp_trees.origin
    source = f"what the cameras of {told.source} see"
    angles = {tree.placed.setup.field_of_view_deg for tree in crisp_trees.trees}
    cones = [f"a camera sees a cone of {angle:g} degrees" for angle in sorted(angles)]
    origin = Origin(source, told.simulated or grid.simulated, told.notices)
    if blind:
        cones.append(f"{blind} nodes have their camera outside of free cells, and see nothing")
    return origin.with_notice(*grid.notices, *cones, MEANING[parameters.reading], CLEAR)


def _tabulate(sets: tuple[VisibilitySet, ...], cells: int) -> "pandas.DataFrame":
    import pandas

    seen = np.array([one.first_nodes >= 0 for one in sets]).reshape(-1, cells)
    names = [*(one.name for one in sets), UNION]
    counts = [*seen.sum(axis=1).tolist(), int(seen.any(axis=0).sum())]
    nodes = [len(one.seconds) for one in sets]
    seconds = [float(one.seconds.max(initial=0)) for one in sets]
    rates = [n / s * HOUR_S if s else np.nan for n, s in zip(nodes, seconds, strict=True)]
    return pandas.DataFrame(
        {
            "name": names,
            "share_seen": [count / cells for count in counts],
            "cells_seen": counts,
            "cells": cells,
            "nodes": [*nodes, sum(nodes)],
            "seconds": [*seconds, max(seconds, default=0.0)],
            "nodes_per_hour": [*rates, np.nan],
        }
    )
