"""The shape of one configuration of a concentric tube robot, for files, pages and planners."""

from itertools import pairwise

import numpy as np
from jaxtyping import Float

from nodes.geometry.origin import Origin
from nodes.mechanics.concentric_tube_solution import ConcentricTubeSolution
from nodes.mechanics.concentric_tube_strains import largest_strains
from nodes.mechanics.describe_robots import describe_concentric_tubes, tell_overbent
from nodes.mechanics.parameters import ShapeConcentricTubesParameters
from nodes.mechanics.robots import ConcentricTubeConfiguration, ConcentricTubeRobot
from nodes.mechanics.shapes import Figure, RobotShape, Rod
from nodes.mechanics.solve_concentric_tubes import solve_concentric_tubes


def shape_concentric_tubes(
    concentric_tube_robot: ConcentricTubeRobot,
    concentric_tube_configuration: ConcentricTubeConfiguration,
    parameters: ShapeConcentricTubesParameters,
) -> RobotShape:
    """Find the shape that the tubes take, unloaded and torsionally compliant, [Rucker2010].

    Parameters
    ----------
    concentric_tube_robot, concentric_tube_configuration : tubes and joint values.
    parameters : spacing of the samples.

    Returns
    -------
    One rod for each tube where it is the outermost; tubes that end where the next one does have
    none.

    Raises
    ------
    BadInput if the robot cannot take the configuration.
    """
    robot, configuration = concentric_tube_robot, concentric_tube_configuration
    tips = configuration.translations_mm + [tube.length_mm for tube in robot.tubes]
    places = _places(tips, parameters.sample_spacing_mm)
    solution = solve_concentric_tubes(robot, configuration, None, places)
    found = len(solution.arc_lengths_mm) > 0
    strains = largest_strains(robot, configuration, solution) if found else np.empty(0)
    return RobotShape(
        kind="concentric tubes",
        status=solution.status,
        reason=solution.reason,
        given=describe_concentric_tubes(robot, configuration),
        rods=_rods(robot, tips, solution) if found else (),
        patient_from_tip=solution.patient_from_tip if found else np.empty((0, 0)),
        joints_patient_mm=np.empty((0, 3)),
        loads=np.empty((0, 6)),
        figures=_figures(robot, solution, strains) if found else (),
        origin=_origin(robot, solution).with_notice(*_overbent(robot, strains)),
    )


def _places(tips: Float[np.ndarray, "tube"], spacing: float) -> Float[np.ndarray, "n"]:
    """Return places from the entry to the tip, evenly between the ends of the tubes."""
    ends = np.unique(np.append(np.maximum(tips, 0.0), 0.0))
    parts = [
        np.linspace(low, high, int(np.ceil((high - low) / spacing)) + 1)
        for low, high in pairwise(ends)
    ]
    return np.unique(np.concatenate([ends[:1], *parts]))


def _rods(
    robot: ConcentricTubeRobot, tips: Float[np.ndarray, "tube"], solution: ConcentricTubeSolution
) -> tuple[Rod, ...]:
    arcs, rods = solution.arc_lengths_mm, []
    around = np.append(tips[1:], 0.0)
    for number, (tube, low, high) in enumerate(zip(robot.tubes, around, tips, strict=True), 1):
        seen = (arcs >= low) & (arcs <= high)
        if high > low:
            rods.append(
                Rod(
                    f"tube {number}",
                    arcs[seen],
                    solution.points_patient_mm[seen],
                    solution.tangents[seen],
                    tube.radius_mm,
                )
            )
    return tuple(rods)


def _figures(
    robot: ConcentricTubeRobot,
    solution: ConcentricTubeSolution,
    strains: Float[np.ndarray, "tube"],
) -> tuple[Figure, ...]:
    bent = [
        Figure(
            f"bending strain of tube {number}",
            float(100 * strain),
            "%",
            "largest along the tube, against its own curve; its material comes back from"
            f" {100 * tube.material.recoverable_strain:.3g} %",
        )
        for number, (tube, strain) in enumerate(zip(robot.tubes, strains, strict=True), 1)
    ]
    return (
        Figure(
            "stability determinant",
            solution.determinant,
            "",
            "how far bases turn for tips that turn, as a volume; 1 where tubes don't twist each"
            " other, 0 where the robot snaps",
        ),
        Figure(
            "least stability determinant",
            solution.least_determinant,
            "",
            "the same at these translations with tubes aligned or opposed, whichever is least;"
            " above 0 every rotation has one shape",
        ),
        Figure(
            "residual",
            solution.residual_rad,
            "rad",
            "largest error of a rotation before the last Newton step; after it the tip is exact to"
            " 1e-6 mm",
        ),
        *bent,
    )


def _overbent(robot: ConcentricTubeRobot, strains: Float[np.ndarray, "k"]) -> list[str]:
    return [
        tell_overbent(f"tube {number}", float(strain), tube.material)
        for number, (tube, strain) in enumerate(zip(robot.tubes, strains, strict=False), 1)
        if strain > tube.material.recoverable_strain
    ]


def _origin(robot: ConcentricTubeRobot, solution: ConcentricTubeSolution) -> Origin:
    origin = Origin(
        "torsionally compliant mechanics of unloaded concentric tubes",
        robot.origin.simulated,
        robot.origin.notices,
    ).with_notice("the tubes carry no load, touch without friction and fit without play")
    if not len(solution.arc_lengths_mm):
        return origin
    if solution.one_solution:
        return origin.with_notice("at these translations every rotation has one shape")
    return origin.with_notice(
        "at these translations some rotations have several stable shapes: which one the robot takes"
        " depends on the way to it, and turning it may make it snap"
    )
