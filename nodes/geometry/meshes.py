"""Triangle surfaces in the patient frame."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.origin import Origin


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh; triangles wind counter-clockwise seen from outside.

    Parameters
    ----------
    vertices_patient_mm : (v, 3) float32, LPS mm.
    triangles : (t, 3) int32 vertex indices.
    """

    vertices_patient_mm: Float[np.ndarray, "v 3"]
    triangles: Int[np.ndarray, "t 3"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class Surfaces:
    """Named surfaces of one anatomy; names are those of the label map that they bound.

    Parameters
    ----------
    meshes : name to mesh; a tuple of pairs, so that the order is part of the value.
    origin : source, what is simulated, notices.
    """

    meshes: tuple[tuple[str, Mesh], ...]
    origin: Origin
