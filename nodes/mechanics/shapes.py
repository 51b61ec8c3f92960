"""The shape of a robot as all later stages, files and pages take it, whatever robot it is."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.origin import Origin

Status = Literal["solved", "no solution", "not converged", "unstable"]


@dataclass(frozen=True)
class Rod:
    """One tube, or the part of one that is the outermost, along its axis.

    Parameters
    ----------
    arc_lengths_mm : (n,) increasing, mm, from where the robot's or needle's entry point is.
    points_patient_mm : (n, 3) patient LPS mm.
    tangents : (n, 3) unit vectors towards the tip, in patient axes.
    outer_radius_mm : mm.
    """

    name: str
    arc_lengths_mm: Float[np.ndarray, "n"]
    points_patient_mm: Float[np.ndarray, "n 3"]
    tangents: Float[np.ndarray, "n 3"]
    outer_radius_mm: float

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class Figure:
    """One number about a shape that a person reads, such as its residual or its margin.

    Parameters
    ----------
    name : what it is, in the field's words.
    unit : "" where it has none.
    meaning : one sentence: what it tells and which values are good.
    """

    name: str
    value: float
    unit: str
    meaning: str


@dataclass(frozen=True)
class RobotShape:
    """The shape that mechanics found, or why there is none.

    Parameters
    ----------
    kind : what robot it is.
    status : only "solved" is a shape to build on; "unstable" has rods, to be looked at alone.
    reason : why it is not solved, for a person; empty if it is.
    given : what was asked for: joint values, tubes, grasps, loads.
    rods : all rods; empty where nothing was found.
    patient_from_tip : (4, 4), or (0, 0) where nothing was found; z is the tangent.
    joints_patient_mm : (joint, 3) where snares grasp.
    loads : (load, 6) place and force of the point loads, patient axes, mm and N.
    figures : residual, margins, energy, strain.
    """

    kind: Literal["concentric tubes", "CRISP"]
    status: Status
    reason: str
    given: tuple[Figure, ...]
    rods: tuple[Rod, ...]
    patient_from_tip: Float[np.ndarray, "k k"]
    joints_patient_mm: Float[np.ndarray, "joint 3"]
    loads: Float[np.ndarray, "load 6"]
    figures: tuple[Figure, ...]
    origin: Origin

    def __post_init__(self) -> None:
        freeze_arrays(self)
