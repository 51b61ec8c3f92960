"""What visibility makes: which cells of the surface a robot's camera sees, and since when."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.lines_of_sight import Reading
from nodes.geometry.origin import Origin


@dataclass(frozen=True)
class VisibilitySet:
    """What one tree of a set-up sees.

    Parameters
    ----------
    name : of the set-up.
    first_nodes : (cell,) the first node of the tree that sees each cell, or -1.
    seconds : (node,) since the tree began to grow, when the node was there; looking, which nodes
        may not time, is not in it.
    """

    name: str
    first_nodes: Int[np.ndarray, "cell"]
    seconds: Float[np.ndarray, "node"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class VisibilitySets:
    """What several set-ups see of one surface.

    Parameters
    ----------
    cells : (cell, 3) indices of the boundary cells in the occupancy grid, in the grid's order.
    patient_from_index : (4, 4) of that grid.
    shape : of that grid.
    """

    cells: Int[np.ndarray, "cell 3"]
    patient_from_index: Float[np.ndarray, "4 4"]
    shape: tuple[int, int, int]
    reading: Reading
    sets: tuple[VisibilitySet, ...]
    origin: Origin

    def __post_init__(self) -> None:
        freeze_arrays(self)
