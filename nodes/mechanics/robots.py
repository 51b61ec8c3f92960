"""Robots as data: materials, tubes, concentric tube robots, CRISP setups, and configurations.

No impossible robot can be made: each type refuses what breaks a rule of its own. What a
configuration may be depends on the robot too: `check_robots.py`.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Float

from nodes.geometry.arrays import freeze_arrays
from nodes.geometry.origin import Origin
from nodes.mechanics.check_numbers import (
    check_counts,
    check_finite,
    check_inside,
    check_limits,
    check_pose,
    check_range,
    check_rotation,
)
from nodes.mechanics.check_setups import check_entries_apart, check_joint, check_snares
from nodes.mechanics.check_tubes import check_diameters, check_lengths, check_nest, check_strain


@dataclass(frozen=True)
class Material:
    """What a tube is made of.

    Parameters
    ----------
    young_modulus_mpa : Young's modulus E, MPa.
    poisson_ratio : Poisson's ratio nu, from 0 to 0.5, without unit.
    recoverable_strain : largest strain from which it comes back, without unit.
    """

    name: str
    young_modulus_mpa: float
    poisson_ratio: float
    recoverable_strain: float

    def __post_init__(self) -> None:
        check_inside("young_modulus_mpa", self.young_modulus_mpa, "MPa", 0.0)
        check_range("poisson_ratio", self.poisson_ratio, "", 0.0, 0.5)
        check_inside("recoverable_strain", self.recoverable_strain, "", 0.0)


@dataclass(frozen=True)
class RoundTube:
    """What all tubes have, whatever robot they are of.

    Parameters
    ----------
    inner_diameter_mm, outer_diameter_mm : mm; inner 0 is a wire.
    """

    material: Material
    inner_diameter_mm: float
    outer_diameter_mm: float

    def __post_init__(self) -> None:
        check_diameters(self.inner_diameter_mm, self.outer_diameter_mm)

    @property
    def radius_mm(self) -> float:
        """Outer radius, mm."""
        return self.outer_diameter_mm / 2

    @property
    def bending_stiffness(self) -> float:
        """E I, N mm^2, with I = pi / 64 (OD^4 - ID^4)."""
        area_moment = np.pi / 64 * (self.outer_diameter_mm**4 - self.inner_diameter_mm**4)
        return float(self.material.young_modulus_mpa * area_moment)

    @property
    def torsional_stiffness(self) -> float:
        """G J = E I / (1 + nu), N mm^2, since J = 2 I and G = E / (2 (1 + nu))."""
        return self.bending_stiffness / (1 + self.material.poisson_ratio)


@dataclass(frozen=True)
class Tube(RoundTube):
    """A tube of a concentric tube robot: straight from its base, then curved about its own y axis.

    Parameters
    ----------
    straight_length_mm, curved_length_mm : mm.
    curvature_per_mm : of the curved part when nothing bends it, 1/mm.
    """

    straight_length_mm: float
    curved_length_mm: float
    curvature_per_mm: float

    def __post_init__(self) -> None:
        super().__post_init__()
        check_lengths(self.straight_length_mm, self.curved_length_mm)
        strain = self.material.recoverable_strain
        check_strain("curvature_per_mm", self.curvature_per_mm, 0.0, self.outer_diameter_mm, strain)

    @property
    def length_mm(self) -> float:
        """Straight and curved part together, mm."""
        return self.straight_length_mm + self.curved_length_mm


@dataclass(frozen=True)
class ConcentricTubeRobot:
    """One to four nested tubes, the innermost first, that leave a base along its +z.

    Parameters
    ----------
    tubes : innermost first; none is shorter than the one around it.
    patient_from_base : (4, 4) rigid, mm; origin where the tubes leave the base.
    translation_limits_mm : (tube, 2) least and largest translation of each tube, mm; None where
        only the order of bases and tips limits them.
    rotation_limits_rad : (tube, 2) least and largest rotation, rad; None where they turn freely.
    """

    tubes: tuple[Tube, ...]
    patient_from_base: Float[np.ndarray, "4 4"]
    origin: Origin = field(default_factory=lambda: Origin("a robot handed in"))
    translation_limits_mm: Float[np.ndarray, "tube 2"] | None = None
    rotation_limits_rad: Float[np.ndarray, "tube 2"] | None = None

    def __post_init__(self) -> None:
        freeze_arrays(self)
        check_nest(
            tuple(tube.inner_diameter_mm for tube in self.tubes),
            tuple(tube.outer_diameter_mm for tube in self.tubes),
            tuple(tube.length_mm for tube in self.tubes),
        )
        check_pose("patient_from_base", self.patient_from_base)
        check_limits("translation_limits_mm", self.translation_limits_mm, len(self.tubes))
        check_limits("rotation_limits_rad", self.rotation_limits_rad, len(self.tubes))


@dataclass(frozen=True)
class ConcentricTubeConfiguration:
    """Joint values of a concentric tube robot, innermost tube first.

    Parameters
    ----------
    rotations_rad : (tube,) theta_i, angle of tube i where it is clamped, rad.
    translations_mm : (tube,) beta_i <= 0, place of tube i's base along the base's z, mm.
    """

    rotations_rad: Float[np.ndarray, "tube"]
    translations_mm: Float[np.ndarray, "tube"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


@dataclass(frozen=True)
class Needle(RoundTube):
    """A tube of a CRISP robot, the same along all of its length.

    Parameters
    ----------
    precurvature_per_mm : (3,) curvature about the body's x and y and twist about z of the needle
        when nothing bends it, 1/mm; zeros for a straight one.
    """

    precurvature_per_mm: Float[np.ndarray, "3"]

    def __post_init__(self) -> None:
        super().__post_init__()
        freeze_arrays(self)
        check_finite("precurvature_per_mm", self.precurvature_per_mm)
        bending = float(np.hypot(*self.precurvature_per_mm[:2]))
        twist = float(self.precurvature_per_mm[2])
        strain = self.material.recoverable_strain
        check_strain("precurvature_per_mm", bending, twist, self.outer_diameter_mm, strain)


@dataclass(frozen=True)
class Snare:
    """Where and how the tip of one needle grasps the tool.

    Parameters
    ----------
    needle : index into the setup's needles, from 1; the tool is needle 0.
    grasp_mm : place on the tool, mm, measured from what `measured_from` says.
    measured_from : "tip": the snare holds the tool's material, and moves with its insertion;
        "entry": at this arc length from the tool's entry point, which the paper leaves open.
    joint : "rigid" [Kuntz2017] eq. (6); "relaxed" [Anderson2017] eq. (6), (16).
    cosine : of the angle between the tangents of tool and snare at a relaxed joint, d_k; 0 at
        right angles.
    """

    needle: int
    grasp_mm: float
    measured_from: Literal["tip", "entry"] = "tip"
    joint: Literal["rigid", "relaxed"] = "relaxed"
    cosine: float = 0.0

    def __post_init__(self) -> None:
        check_joint(self.joint, self.cosine, self.grasp_mm)


@dataclass(frozen=True)
class CrispSetup:
    """What is fixed before a CRISP robot moves; the tool, which carries the camera, is needle 0.

    Parameters
    ----------
    entry_points_patient_mm : (needle, 3), patient LPS mm.
    snares : any order; each grasps the tool with the tip of a needle of its own.
    field_of_view_deg : full angle of the camera's cone about the tool's tangent, degrees.
    """

    needles: tuple[Needle, ...]
    entry_points_patient_mm: Float[np.ndarray, "needle 3"]
    snares: tuple[Snare, ...]
    field_of_view_deg: float
    origin: Origin = field(default_factory=lambda: Origin("a setup handed in"))

    def __post_init__(self) -> None:
        freeze_arrays(self)
        check_snares(tuple(snare.needle for snare in self.snares), len(self.needles))
        entries = self.entry_points_patient_mm
        check_counts({"needles": len(self.needles), "entry_points_patient_mm": len(entries)})
        check_finite("entry_points_patient_mm", entries)
        check_entries_apart(entries, tuple(needle.radius_mm for needle in self.needles))
        check_inside("field_of_view_deg", self.field_of_view_deg, "degrees", 0.0, 180.0)


@dataclass(frozen=True)
class PointLoad:
    """What the surroundings apply on the tool at one place.

    Parameters
    ----------
    arc_length_mm : from the tool's entry point, mm.
    force_n : (3,) in patient axes, N.
    moment_n_mm : (3,) in patient axes, N mm.
    """

    arc_length_mm: float
    force_n: Float[np.ndarray, "3"]
    moment_n_mm: Float[np.ndarray, "3"]

    def __post_init__(self) -> None:
        freeze_arrays(self)
        check_range("arc_length_mm", self.arc_length_mm, "mm", 0.0)
        check_finite("force_n", self.force_n)
        check_finite("moment_n_mm", self.moment_n_mm)


@dataclass(frozen=True)
class CrispConfiguration:
    """Joint values of a CRISP robot, the tool first.

    Parameters
    ----------
    patient_from_entry : (needle, 3, 3) rotations of the needles where they enter; the third column
        is the tangent.
    lengths_mm : (needle,) how far each reaches beyond its entry point, mm.
    loads : what pulls on the tool.
    """

    patient_from_entry: Float[np.ndarray, "needle 3 3"]
    lengths_mm: Float[np.ndarray, "needle"]
    loads: tuple[PointLoad, ...] = ()

    def __post_init__(self) -> None:
        freeze_arrays(self)
        for needle, rotation in enumerate(self.patient_from_entry):
            check_rotation(f"patient_from_entry[{needle}]", rotation)
