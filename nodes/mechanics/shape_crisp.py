"""The shape of a CRISP robot in one configuration, as all later stages take it."""

import numpy as np

from nodes.kernels.crisp_general_problem import Crisp
from nodes.mechanics.check_robots import check_crisp_configuration
from nodes.mechanics.crisp_solution import CrispSolution
from nodes.mechanics.describe_robots import describe_crisp, name_needle, tell_overbent
from nodes.mechanics.parameters import ShapeCrispParameters
from nodes.mechanics.robots import CrispConfiguration, CrispSetup
from nodes.mechanics.shapes import Figure, RobotShape, Rod
from nodes.mechanics.solve_crisp import solve_crisp, to_crisp

ASSUMED = "joints are assumed to hold without play, needles neither to stretch nor to shear"

LEAST_MARGIN = -1e6  # what is told of a margin that is not bounded below

_MARGIN = "1 for a free robot; it falls towards 0, where the robot snaps to another shape"
_ENERGY = (
    "elastic energy less force times place, from the patient's origin; of several shapes of one"
    " robot the least rests"
)
_RESIDUAL = "what is left of the joints' conditions; the solver asks for its tolerance"
_BALANCE = "what entry points and loads do not cancel; 0 but for rounding and integration"
_SPARE = "by which the needle with the least is longer than the straight way to its joint"
_FORCE = "that a snare and the tool exert on each other"
_ANGLE = "between tool and snare; 90 is a right angle, at 0 they lie along each other"


def shape_crisp(
    crisp_setup: CrispSetup,
    crisp_configuration: CrispConfiguration,
    parameters: ShapeCrispParameters,
) -> RobotShape:
    """Return the shape in which a CRISP robot rests: the stable one of least energy found.

    [Kuntz2017] Sec. IV-B, [Anderson2017] Sec. II-A.

    Raises
    ------
    BadInput where no shape of the robot can have these lengths, grasps and loads.
    """
    check_crisp_configuration(crisp_setup, crisp_configuration)
    solution = solve_crisp(crisp_setup, crisp_configuration, parameters)
    return RobotShape(
        "CRISP",
        solution.status,
        solution.reason,
        describe_crisp(crisp_setup, crisp_configuration),
        _rods(crisp_setup, solution),
        solution.patient_from_camera,
        solution.patient_from_joints[:, :3, 3],
        _loads(crisp_configuration, solution),
        _figures(crisp_setup, crisp_configuration, solution),
        crisp_setup.origin.with_notice(
            "the robot's shape is computed, not measured",
            ASSUMED,
            *_notices(crisp_configuration),
            *_overbent(crisp_setup, solution),
        ),
    )


def _rods(setup: CrispSetup, solution: CrispSolution) -> tuple[Rod, ...]:
    return tuple(
        Rod(
            name_needle(number),
            state.arc_lengths_mm,
            state.points_patient_mm,
            state.patient_from_body[:, :, 2],
            needle.outer_diameter_mm / 2,
        )
        for number, (state, needle) in enumerate(zip(solution.rods, setup.needles, strict=False))
    )


def _notices(configuration: CrispConfiguration) -> list[str]:
    if any(np.any(load.moment_n_mm) for load in configuration.loads):
        return ["a moment on the tool keeps its axis while the tool turns; its work is left out"]
    return []


def _loads(configuration: CrispConfiguration, solution: CrispSolution) -> np.ndarray:
    """Return place and force of each load; none without a shape."""
    if not solution.rods:
        return np.empty((0, 6))
    tool = solution.rods[0]
    rows = []
    for load in configuration.loads:
        here = int(np.argmin(np.abs(tool.arc_lengths_mm - load.arc_length_mm)))
        rows.append([*tool.points_patient_mm[here], *load.force_n])
    return np.array(rows, float).reshape(-1, 6)


def _figures(
    setup: CrispSetup, configuration: CrispConfiguration, solution: CrispSolution
) -> tuple[Figure, ...]:
    """Return the numbers that a person judges the shape by."""
    if not solution.rods:
        return ()
    figures = [
        Figure("stability margin", max(solution.stability_margin, LEAST_MARGIN), "", _MARGIN),
        Figure("energy", solution.energy_n_mm, "N mm", _ENERGY),
        *_strains(setup, solution),
        Figure("residual", solution.residual_mm, "mm", _RESIDUAL),
        Figure("force out of balance", float(abs(solution.imbalance[3:]).max()), "N", _BALANCE),
        Figure("moment out of balance", float(abs(solution.imbalance[:3]).max()), "N mm", _BALANCE),
    ]
    if setup.snares:
        crisp = to_crisp(setup, configuration)
        figures += [
            Figure("length to spare", _spare_length(crisp, solution), "mm", _SPARE),
            Figure("largest force at a joint", _joint_force(solution), "N", _FORCE),
            Figure("least angle at a joint", _joint_angle(crisp, solution), "deg", _ANGLE),
        ]
    return tuple(figures)


def _strains(setup: CrispSetup, solution: CrispSolution) -> list[Figure]:
    return [
        Figure(
            f"bending strain of {name_needle(number)}",
            float(100 * strain),
            "%",
            "largest along the needle; its material comes back from"
            f" {100 * needle.material.recoverable_strain:.3g} %",
        )
        for number, (needle, strain) in enumerate(
            zip(setup.needles, solution.bending_strains, strict=True)
        )
    ]


def _overbent(setup: CrispSetup, solution: CrispSolution) -> list[str]:
    return [
        tell_overbent(name_needle(number), float(strain), needle.material)
        for number, (needle, strain) in enumerate(
            zip(setup.needles, solution.bending_strains, strict=False)
        )
        if strain > needle.material.recoverable_strain
    ]


def _spare_length(crisp: Crisp, solution: CrispSolution) -> float:
    """Return how much longer the tautest snare is than the straight way to where it grasps."""
    snares = crisp.grasps.snare
    ways = solution.patient_from_joints[:, :3, 3] - crisp.rods.entry[snares]
    return float(np.min(crisp.lengths[snares] - np.linalg.norm(ways, axis=1)))


def _joint_force(solution: CrispSolution) -> float:
    return float(np.linalg.norm(solution.joint_wrenches[:, 3:], axis=1).max())


def _joint_angle(crisp: Crisp, solution: CrispSolution) -> float:
    """Return how near to parallel tool and snare come where one grasps, degrees."""
    tips = [solution.rods[rod].patient_from_body[-1, :, 2] for rod in crisp.grasps.snare]
    cosines = np.einsum("ki,ki->k", solution.patient_from_joints[:, :3, 2], np.array(tips))
    return float(np.degrees(np.arccos(np.clip(np.abs(cosines).max(), 0, 1))))
