"""Places that a person marks in the patient: where a robot starts, what it has to reach."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.origin import Origin


@dataclass(frozen=True)
class Sites:
    """Named poses and points; without arguments, none.

    Parameters
    ----------
    pose_names : (p) names of the poses.
    patient_from_site : (p, 4, 4) rigid, as exactly as the person wrote it; the columns of its
        rotation are the site's axes in patient LPS. Which of them a robot starts along is for the
        person to say; in Med-RAD's start poses the third one leads towards the target.
    point_names : (n) names of the points.
    points_patient_mm : (n, 3) patient LPS mm.
    origin : source, what is simulated, notices.
    """

    pose_names: tuple[str, ...] = ()
    patient_from_site: Float[np.ndarray, "p 4 4"] = field(
        default_factory=lambda: np.zeros((0, 4, 4))
    )
    point_names: tuple[str, ...] = ()
    points_patient_mm: Float[np.ndarray, "n 3"] = field(default_factory=lambda: np.zeros((0, 3)))
    origin: Origin = field(default_factory=lambda: Origin("no sites given"))

    def __post_init__(self) -> None:
        freeze_arrays(self)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of all sites, poses first."""
        return self.pose_names + self.point_names

    @property
    def places_patient_mm(self) -> Float[np.ndarray, "sites 3"]:
        """Return where all sites are, in the order of `names`; (sites, 3) patient LPS mm."""
        return np.concatenate([self.patient_from_site[:, :3, 3], self.points_patient_mm])
