"""Concentric tube robots and room for their outcomes, as the kernels take them."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from nodes.mechanics.robots import ConcentricTubeRobot

if TYPE_CHECKING:
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
    base = robot.patient_from_base
    frame = np.concatenate([base[:3, :3].ravel(), base[:3, 3]])
    return Tubes(bending, torsion, curvature, straight, length, weight, frame)


def bent_backwards(robot: ConcentricTubeRobot) -> Float[np.ndarray, " tube"]:
    """Return pi for each tube of negative curvature: turned so far it is one of positive."""
    return np.array([np.pi if tube.curvature_per_mm < 0 else 0.0 for tube in robot.tubes])


def with_ghost(values: Float[np.ndarray, "k tube"]) -> Float[np.ndarray, "k n"]:
    """Return a writable copy with a column of zeros for the ghost around a single tube."""
    values = np.array(values, float, order="C")
    return values if values.shape[1] > 1 else np.concatenate([values, 0 * values], axis=1)


def make_scratch(tubes: int, places: int = 0, samples: int = 0) -> "Scratch":
    """Return room for configurations of that many tubes, ghost included.

    Parameters
    ----------
    places : at which one of them is traced.
    samples : points of each that are wanted.
    """
    from nodes.kernels.ctr_approach import BLOCKS
    from nodes.kernels.ctr_lanes import LANES, make_rooms
    from nodes.kernels.ctr_nodes import END_ROWS, ROWS, Nodes
    from nodes.kernels.ctr_outcomes import Scratch
    from nodes.kernels.ctr_sections import Sections

    breaks, count = 2 * tubes + 1, MOST_STEPS + places
    states = [(count, tubes * (tubes - 1))] * 5
    shapes = [(count,), *states, (count, 12), (-(-count // LANES) * ROWS, LANES), (END_ROWS, LANES)]
    group = (BLOCKS + (breaks + 1) * (2 + 2 * tubes), LANES)
    cuts = [(LANES, breaks), (LANES, breaks, tubes), (LANES, breaks, tubes)]
    rooms = make_rooms((2 * tubes, 6), *shapes, (samples + LANES, 3), *cuts, group, (2, 3, tubes))
    twists, *nodes, place, share, drive, group, way = rooms
    whole = [np.zeros((LANES, breaks, *more), np.int64) for more in ((), (2,))]
    sections = Sections(place, share, drive, np.zeros((LANES, breaks), np.bool_), *whole)
    room = Nodes(nodes[0], np.zeros(count, np.int64), *nodes[1:])
    return Scratch(sections, room, *way, twists, np.zeros(LANES, np.int64), group)


def make_outcomes(
    count: int, tubes: int, samples: int, with_least: bool, with_jacobian: bool
) -> "Outcomes":
    """Return room for the outcomes of `count` configurations, which the kernel fills."""
    from nodes.kernels.ctr_outcomes import Outcomes

    empty = np.empty
    return Outcomes(
        status=empty(count, np.int64),
        tips=empty((count, tubes)),
        entries=empty((count, tubes)),
        twists=empty((count, tubes)),
        frame=empty((count, 12)),
        determinant=empty(count),
        residual=empty(count),
        least=empty(count if with_least else 0),
        places=empty((count if samples else 0, samples)),
        points=empty((count if samples else 0, samples, 3)),
        jacobian=empty((count if with_jacobian else 0, 6, 2 * tubes)),
    )
