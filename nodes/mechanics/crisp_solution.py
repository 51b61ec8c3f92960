"""What CRISP mechanics finds for one configuration: an equilibrium, or why there is none."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from nodes.geometry.arrays import freeze_arrays
from nodes.mechanics.shapes import Status


@dataclass(frozen=True)
class RodState:
    """One needle from its entry point to its end.

    Parameters
    ----------
    arc_lengths_mm : (q,) increasing, mm from the entry point.
    points_patient_mm : (q, 3).
    patient_from_body : (q, 3, 3) rotations; the third column is the tangent.
    wrenches : (q, 6) moment (N mm) and force (N) that the far side exerts, patient axes; where
        something acts on the needle, those just before it.
    """

    arc_lengths_mm: Float[np.ndarray, "q"]
    points_patient_mm: Float[np.ndarray, "q 3"]
    patient_from_body: Float[np.ndarray, "q 3 3"]
    wrenches: Float[np.ndarray, "q 6"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class CrispSolution:
    """An equilibrium of a CRISP robot, or why there is none; then it has no rods.

    Parameters
    ----------
    status : "unstable" is an equilibrium that the robot would leave, or whose margin is 0 but for
        its error, such as that of a column free to swing round its axis.
    reason : why it is not solved, in plain words and numbers; empty if it is.
    base_wrenches : (n, 6) moment (N mm) and force (N) at the needles' entry points, patient axes,
        the tool first; a start for configurations near by. The last guess where none was found.
    residual_mm : what is left of joints and tip; angles count by the tool's length, moments by
        the deflection that they make.
    iterations : evaluations of the derivatives.
    rods : the tool first.
    patient_from_camera : (4, 4) at the tool's tip; z is the tangent; (0, 0) without rods.
    patient_from_joints : (k, 4, 4) the tool's frames where snares grasp, in order along the tool.
    joint_wrenches : (k, 6) what the tool exerts on the snares' tips, moment first.
    energy_n_mm : elastic energy less the work of the loads' forces, which vanish at the origin;
        without that of moments, which depends on the way that the tool was turned.
    stability_margin : least eigenvalue of the second variation of the energy in the curvatures,
        over their elastic energy, as the joints allow: 1 for a free needle, 0 where it snaps. A
        moment load that keeps its world axis has no energy [Ziegler1968] and a second
        variation that is not symmetric; its symmetric part is taken. The margin is then an
        estimate, near 0 to be doubted, and says nothing of motions that the moment keeps feeding.
    bending_strains : (n,) largest of each needle at its surface.
    imbalance : (6,) moment about the origin (N mm) and force (N) left between entry points and
        loads.
    """

    status: Status
    reason: str
    base_wrenches: Float[np.ndarray, "n 6"]
    residual_mm: float
    iterations: int
    rods: tuple[RodState, ...]
    patient_from_camera: Float[np.ndarray, "pose pose"]
    patient_from_joints: Float[np.ndarray, "k 4 4"]
    joint_wrenches: Float[np.ndarray, "k 6"]
    energy_n_mm: float
    stability_margin: float
    bending_strains: Float[np.ndarray, "strains"]
    imbalance: Float[np.ndarray, "6"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


def unsolved(status: Status, reason: str, wrenches: Float[np.ndarray, "n 6"]) -> CrispSolution:
    """Return what says that nothing was found."""
    return CrispSolution(
        status,
        reason,
        wrenches,
        np.inf,
        0,
        (),
        np.empty((0, 0)),
        np.empty((0, 4, 4)),
        np.empty((0, 6)),
        np.nan,
        np.nan,
        np.empty(0),
        np.full(6, np.nan),
    )
