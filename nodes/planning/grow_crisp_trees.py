"""Trees of motions of CRISP robots through free space."""

from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.origin import Origin
from nodes.planning.artefacts import CrispTrees, Goals, PlacedSetups
from nodes.planning.cavity import make_cavity, make_wall
from nodes.planning.crisp_collisions import refuse_coarse_cells
from nodes.planning.parameters import GrowCrispTreesParameters
from nodes.planning.tree_growth import grow_tree


def grow_crisp_trees(
    placed_setups: PlacedSetups,
    occupancy_grid: LabelMap,
    distance_field: Volume,
    label_map: LabelMap,
    goals: Goals,
    parameters: GrowCrispTreesParameters,
) -> CrispTrees:
    """Grow a tree of configurations for each set-up, from its start [Kuntz2017] Sec. IV-A.

    A configuration is drawn at random, and the tree grows towards it from its nearest node in small
    steps, each solved from the one before and tested for touching, up to the last that is valid.
    Nodes at walls, from which edges fail at once, may move some joints only, to slide along.
    All needles are straight when nothing bends them. Same seed and limit of nodes, same trees,
    whatever the machine's threads; only `seconds`, and an ending by time, depend on the clock.

    Raises
    ------
    BadInput : if a start has no stable solution or touches anything; if needles are curved; if
        cells are too coarse for the needles; if joints pass one another on the tool.
    """
    cavity = make_cavity(occupancy_grid, distance_field)
    wall = make_wall(label_map, parameters.sheath_avoids)
    notices = [
        refuse_coarse_cells(occupancy_grid, placed.setup, parameters)
        for placed in placed_setups.setups
    ]
    trees = tuple(
        grow_tree(placed, cavity, wall, goals.cells, parameters) for placed in placed_setups.setups
    )
    origin = Origin(
        f"motions found at random from the starts of {placed_setups.origin.source}",
        simulated=True,
        notices=placed_setups.origin.notices + occupancy_grid.origin.notices,
    )
    return CrispTrees(trees, origin.with_notice(*filter(None, notices)))
