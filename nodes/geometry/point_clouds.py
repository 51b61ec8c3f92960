"""Labelled points in the patient frame."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt8

from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.origin import Origin


@dataclass(frozen=True)
class PointCloud:
    """Points on surfaces, each with the outward normal and the label of its surface.

    Parameters
    ----------
    points_patient_mm : (n, 3) float32, LPS mm.
    normals : (n, 3) float32 unit vectors, outward.
    labels : (n,) uint8; label n + 1 is `names[n]`.
    names : names of the labels.
    origin : source, what is simulated, notices.
    """

    points_patient_mm: Float[np.ndarray, "n 3"]
    normals: Float[np.ndarray, "n 3"]
    labels: UInt8[np.ndarray, " n"]
    names: tuple[str, ...]
    origin: Origin

    def __post_init__(self) -> None:
        freeze_arrays(self)
