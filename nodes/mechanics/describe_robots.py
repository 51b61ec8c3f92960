"""What a shape was asked for, in the words of its page: tubes, joint values, grasps, loads."""

import numpy as np
from jaxtyping import Float

from nodes.mechanics.check_robots import grasp_arc_mm
from nodes.mechanics.robots import (
    ConcentricTubeConfiguration,
    ConcentricTubeRobot,
    CrispConfiguration,
    CrispSetup,
    Material,
    RoundTube,
)
from nodes.mechanics.shapes import Figure


def describe_concentric_tubes(
    robot: ConcentricTubeRobot, configuration: ConcentricTubeConfiguration
) -> tuple[Figure, ...]:
    """Return rotation and translation of every tube, and what it is made of."""
    figures = []
    for number, tube in enumerate(robot.tubes):
        name, made = f"tube {number + 1}", _section(tube)
        made += f"; {tube.straight_length_mm:g} mm straight, then {tube.curved_length_mm:g} mm"
        made += f" curved by {tube.curvature_per_mm:.4g} / mm"
        angle = float(np.degrees(configuration.rotations_rad[number]))
        place = float(configuration.translations_mm[number])
        figures += [
            Figure(f"translation of {name}", place, "mm", made),
            Figure(f"rotation of {name}", angle, "deg", "where it is clamped"),
        ]
    return tuple(figures)


def describe_crisp(setup: CrispSetup, configuration: CrispConfiguration) -> tuple[Figure, ...]:
    """Return length, place and direction of every needle, then grasps and loads."""
    figures = []
    for number, needle in enumerate(setup.needles):
        bent = needle.precurvature_per_mm.any()
        way = configuration.patient_from_entry[number, :, 2]
        told = f"from {_vector(setup.entry_points_patient_mm[number])} along {_vector(way)}; "
        told += _section(needle)
        if bent:
            told += f", pre-curved by {_vector(needle.precurvature_per_mm)} / mm"
        length = float(configuration.lengths_mm[number])
        figures.append(Figure(f"length of {name_needle(number)}", length, "mm", told))
    for snare in setup.snares:
        arc = float(grasp_arc_mm(snare, float(configuration.lengths_mm[0])))
        told = f"{snare.joint}, along the tool from its entry point"
        if snare.joint == "relaxed":
            told += f"; cosine between the needles {snare.cosine:g}"
        figures.append(Figure(f"grasp of {name_needle(snare.needle)}", arc, "mm", told))
    for number, load in enumerate(configuration.loads, 1):
        told = f"at {load.arc_length_mm:g} mm of the tool: force {_vector(load.force_n)} N"
        if load.moment_n_mm.any():
            told += f", moment {_vector(load.moment_n_mm)} N mm"
        size = float(np.linalg.norm(load.force_n))
        figures.append(Figure(f"load {number}", size, "N", told))
    return tuple(figures)


def tell_overbent(name: str, strain: float, material: Material) -> str:
    """Return the notice about a tube that is strained more than its material recovers from."""
    return (
        f"{name} is strained by {100 * strain:.3g} %, and {material.name} comes back from"
        f" {100 * material.recoverable_strain:.3g} %: it would stay bent or break, and the shape"
        " shown, for which it is elastic, is not the one it would take"
    )


def name_needle(number: int) -> str:
    """Return what a needle is called on pages and in files: needle 0 is the tool."""
    return f"snare {number}" if number else "tool"


def _section(tube: RoundTube) -> str:
    sizes = f"inner and outer diameter {tube.inner_diameter_mm:g} and {tube.outer_diameter_mm:g} mm"
    return f"{tube.material.name}, E {tube.material.young_modulus_mpa:g} MPa, {sizes}"


def _vector(values: Float[np.ndarray, "3"]) -> str:
    return f"[{', '.join(f'{round(float(value), 9) + 0.0:.5g}' for value in values)}]"
