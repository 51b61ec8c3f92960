"""A CRISP robot and its configuration as the arrays that kernels take."""

import numpy as np

from nodes.kernels.crisp_problem import Grasps, Loads, Rods
from nodes.mechanics.robots import CrispConfiguration, CrispSetup, Needle, Snare


def to_rods(setup: CrispSetup) -> Rods:
    """Return stiffness, pre-curvature and entry point of all needles, the tool first."""
    stiffness = np.array([_stiffness(needle) for needle in setup.needles])
    return Rods(
        np.ascontiguousarray(stiffness[:, 0]),
        np.ascontiguousarray(stiffness[:, 1]),
        np.array([needle.precurvature_per_mm for needle in setup.needles], float),
        np.array(setup.entry_points_patient_mm, float),
    )


def to_grasps(setup: CrispSetup, tool_length_mm: float) -> Grasps:
    """Return the joints sorted along a tool that reaches `tool_length_mm` beyond its entry point.

    Joints at one place keep the setup's order.
    """
    snares = sorted(setup.snares, key=lambda snare: _place(snare, tool_length_mm))
    return Grasps(
        np.array([snare.needle for snare in snares], np.int64),
        np.array([_place(snare, tool_length_mm) for snare in snares], float),
        np.array([snare.joint == "rigid" for snare in snares], bool),
        np.array([snare.cosine for snare in snares], float),
    )


def to_loads(configuration: CrispConfiguration) -> Loads:
    """Return the point loads sorted along the tool; loads at one place keep their order."""
    loads = sorted(configuration.loads, key=lambda load: load.arc_length_mm)
    return Loads(
        np.array([load.arc_length_mm for load in loads], float),
        np.array([load.force_n for load in loads], float).reshape(-1, 3),
        np.array([load.moment_n_mm for load in loads], float).reshape(-1, 3),
    )


def _stiffness(needle: Needle) -> tuple[float, float]:
    """Return E I and G J of a round tube, N mm^2; G = E / (2 (1 + nu)) and J = 2 I."""
    area_moment = np.pi / 64 * (needle.outer_diameter_mm**4 - needle.inner_diameter_mm**4)
    bending = needle.material.young_modulus_mpa * area_moment
    return bending, bending / (1 + needle.material.poisson_ratio)


def _place(snare: Snare, tool_length_mm: float) -> float:
    """Return how far from the tool's entry point a snare grasps, mm."""
    if snare.measured_from == "tip":
        return tool_length_mm - snare.grasp_mm
    return snare.grasp_mm
