"""What the mechanics of concentric tubes finds, for one configuration and for many."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.geometry.arrays import freeze_arrays
from nodes.mechanics.shapes import Status

STATUSES: tuple[Status, ...] = ("solved", "no solution", "not converged", "unstable")


@dataclass(frozen=True)
class ConcentricTubeSolution:
    """One configuration, solved, or why it is not; then its numbers are nan.

    Parameters
    ----------
    status : only "solved" is a shape to build on; "unstable" is an equilibrium that it would leave.
    reason : why it is not solved, for a person; empty if it is.
    tip_angles_rad : (tube,) azimuth psi_i of the bending plane of each tube at its tip: the branch.
    entry_angles_rad, entry_twists_per_mm : (tube,) psi_i and psi_i' at the entry plane; behind it
        a tube twists evenly.
    patient_from_tip : (4, 4) Bishop frame at the innermost tube's tip: that of the base, carried
        along without twist; z is the tangent.
    tip_jacobian : (6, 2 tube) of the tip's place (mm) and rotation vector (rad), both in patient
        axes, by rotations theta_1..n (rad) and translations beta_1..n (mm).
    determinant : of d theta / d tip angles with those of the innermost tube taken off; 1 where
        tubes don't twist each other, 0 where the robot snaps.
    least_determinant : the least of it over all rotations at these translations (at the corners,
        where tubes are aligned or opposed); not above 0 where a rotation exists that snaps.
    one_solution : whether these translations have one equilibrium for every rotation.
    residual_rad : largest error of a rotation, rad, before the last Newton step.
    arc_lengths_mm : (n,) rising, mm from the entry.
    points_patient_mm, tangents : (n, 3) in patient axes.
    angles_rad : (n, tube) psi_i along the robot; beyond its tip that at the tip.
    """

    status: Status
    reason: str
    tip_angles_rad: Float[np.ndarray, "tube"]
    entry_angles_rad: Float[np.ndarray, "tube"]
    entry_twists_per_mm: Float[np.ndarray, "tube"]
    patient_from_tip: Float[np.ndarray, "4 4"]
    tip_jacobian: Float[np.ndarray, "6 joints"]
    determinant: float
    least_determinant: float
    one_solution: bool
    residual_rad: float
    arc_lengths_mm: Float[np.ndarray, "n"]
    points_patient_mm: Float[np.ndarray, "n 3"]
    tangents: Float[np.ndarray, "n 3"]
    angles_rad: Float[np.ndarray, "n tube"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class ConcentricTubeBatch:
    """Many configurations of one robot; rows that are not solved are nan.

    Parameters
    ----------
    status : (k,) index into `STATUSES`; "no solution" where joint values are out of order.
    tip_angles_rad : (k, tube), the branch of each.
    entry_angles_rad, entry_twists_per_mm : (k, tube) psi_i and psi_i' at the entry plane.
    patient_from_tip : (k, 4, 4).
    determinant, residual_rad : (k,).
    least_determinant, one_solution : (k,), or (0,) where not asked for.
    tip_jacobian : (k, 6, 2 tube), or (0, 6, 2 tube) where not asked for.
    arc_lengths_mm, points_patient_mm : (k, n) and (k, n, 3), or (0, 0) and (0, 0, 3).
    """

    status: Int[np.ndarray, "k"]
    tip_angles_rad: Float[np.ndarray, "k tube"]
    entry_angles_rad: Float[np.ndarray, "k tube"]
    entry_twists_per_mm: Float[np.ndarray, "k tube"]
    patient_from_tip: Float[np.ndarray, "k 4 4"]
    determinant: Float[np.ndarray, "k"]
    residual_rad: Float[np.ndarray, "k"]
    least_determinant: Float[np.ndarray, "a"]
    one_solution: Bool[np.ndarray, "a"]
    tip_jacobian: Float[np.ndarray, "b 6 joints"]
    arc_lengths_mm: Float[np.ndarray, "c n"]
    points_patient_mm: Float[np.ndarray, "c n 3"]

    def __post_init__(self) -> None:
        freeze_arrays(self)
