"""Concentric tube robots and room for their outcomes, as the kernels take them."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from nodes.mechanics.robots import ConcentricTubeRobot

if TYPE_CHECKING:
    from nodes.kernels.ctr_nodes import Nodes
    from nodes.kernels.ctr_outcomes import Outcomes, Scratch
    from nodes.kernels.ctr_sections import Tubes

MOST_STEPS = 640  # of one configuration: more than 8 sections of 64 steps


def to_tubes(robot: ConcentricTubeRobot) -> "Tubes":
    """Return the robot's tubes, curved to the positive side.

    One tube alone gets a ghost around it that has no stiffness and ends where it begins, since the
    kernels count in angles between tubes.
    """
    from nodes.kernels.ctr_sections import Tubes

    tubes = robot.tubes
    rows = [
        [tube.bending_stiffness for tube in tubes],
        [tube.torsional_stiffness for tube in tubes],
        [abs(tube.curvature_per_mm) for tube in tubes],
        [tube.straight_length_mm for tube in tubes],
        [tube.length_mm for tube in tubes],
    ]
    torsion = np.array(rows[1])
    weight = torsion / torsion.sum()
    bending, torsion, curvature, straight, length = np.array(rows, float)
    if len(tubes) == 1:
        zero = np.zeros(1)
        bending, torsion = np.append(bending, 0.0), np.append(torsion, 1.0)
        curvature, weight = np.append(curvature, zero), np.append(weight, zero)
        straight, length = np.append(straight, zero), np.append(length, zero)
    return Tubes(bending, torsion, curvature, straight, length, weight)


def bent_backwards(robot: ConcentricTubeRobot) -> Float[np.ndarray, " tube"]:
    """Return pi for each tube of negative curvature: turned so far it is one of positive."""
    return np.array([np.pi if tube.curvature_per_mm < 0 else 0.0 for tube in robot.tubes])


def with_ghost(values: Float[np.ndarray, "k tube"]) -> Float[np.ndarray, "k n"]:
    """Return a writable copy with a column of zeros for the ghost around a single tube."""
    values = np.array(values, float, order="C")
    return values if values.shape[1] > 1 else np.concatenate([values, 0 * values], axis=1)


def make_scratch(tubes: int, places: int = 0) -> "Scratch":
    """Return room for one configuration of that many tubes, ghost included, traced at places."""
    from nodes.kernels.ctr_outcomes import Scratch
    from nodes.kernels.ctr_sections import Sections

    breaks, width = 2 * tubes + 1, tubes * (tubes - 1)
    sections = Sections(
        place=np.zeros(breaks),
        share=np.zeros((breaks, tubes)),
        drive=np.zeros((breaks, tubes)),
        coupled=np.zeros(breaks, np.bool_),
        steps=np.zeros(breaks, np.int64),
        owner=np.zeros((breaks, 2), np.int64),
    )
    nodes = make_nodes(MOST_STEPS + places, width)
    return Scratch(sections, nodes, *np.zeros((2, 3, tubes)), np.zeros((2 * tubes, 10)))


def make_nodes(count: int, width: int) -> "Nodes":
    """Return room for the nodes of one configuration; `width` is that of a state."""
    from nodes.kernels.ctr_nodes import Nodes

    states = [np.zeros((count, width)) for _ in range(5)]
    frame, bend = np.zeros((count, 12)), np.zeros((count, 14))
    turning = np.zeros((count, 9))
    place, section = np.zeros(count), np.zeros(count, np.int64)
    return Nodes(place, section, *states, frame, bend, turning)


def make_outcomes(
    count: int, tubes: int, samples: int, with_least: bool, with_jacobian: bool
) -> "Outcomes":
    """Return room for the outcomes of `count` configurations; all numbers are nan at first."""
    from nodes.kernels.ctr_outcomes import Outcomes

    def empty(*shape: int) -> np.ndarray:
        return np.full(shape, np.nan)

    return Outcomes(
        status=np.zeros(count, np.int64),
        tips=empty(count, tubes),
        entries=empty(count, tubes),
        twists=empty(count, tubes),
        frame=empty(count, 12),
        determinant=empty(count),
        residual=empty(count),
        least=empty(count if with_least else 0),
        places=empty(count if samples else 0, samples),
        points=empty(count if samples else 0, samples, 3),
        jacobian=empty(count if with_jacobian else 0, 6, 2 * tubes),
    )
