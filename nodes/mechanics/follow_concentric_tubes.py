"""A concentric tube robot moved from one configuration to another, on the branch that it is on."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from nodes.geometry.arrays import freeze_arrays
from nodes.mechanics.check_robots import check_concentric_tube_configuration
from nodes.mechanics.concentric_tube_arrays import (
    bent_backwards,
    make_scratch,
    to_tubes,
    with_ghost,
)
from nodes.mechanics.robots import ConcentricTubeConfiguration, ConcentricTubeRobot


@dataclass(frozen=True)
class ConcentricTubeMotion:
    """How far a motion goes before the robot snaps.

    Parameters
    ----------
    snaps : whether stability is lost on the way.
    share : of the way that is safe, 1 if it is followed to its end.
    tip_angles_rad : (tube,) where it ends or, just before, snaps: the branch to go on from.
    """

    snaps: bool
    share: float
    tip_angles_rad: Float[np.ndarray, "tube"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


def follow_concentric_tubes(
    robot: ConcentricTubeRobot,
    start: ConcentricTubeConfiguration,
    end: ConcentricTubeConfiguration,
    tip_angles_rad: Float[np.ndarray, "tube"],
) -> ConcentricTubeMotion:
    """Move all joints evenly from start to end and keep to the branch.

    Each step must settle to a stable configuration near the last one, or is halved; where the
    determinant vanishes no step is short enough, and the robot snaps. Rotations are not wrapped:
    from 0 to 2 pi is a whole turn.

    Parameters
    ----------
    tip_angles_rad : (tube,) at the start, as `solve_concentric_tubes` gives them.

    Raises
    ------
    BadInput if the robot cannot take the start or the end; what lies between, it then can.
    """
    from nodes.kernels.ctr_trace import follow_row

    check_concentric_tube_configuration(robot, start)
    check_concentric_tube_configuration(robot, end)
    offset, count = bent_backwards(robot), len(robot.tubes)
    rotations = with_ghost(np.stack([start.rotations_rad, end.rotations_rad] * 2)[:3] + offset)
    translations = with_ghost(np.stack([start.translations_mm, end.translations_mm] * 2)[:3])
    n = rotations.shape[1]
    tips = with_ghost((tip_angles_rad + offset)[None])[0]
    size, columns = (0.0,) * (n - 1), (0.0,) * (n * (n - 1))
    share = follow_row(
        size, columns, to_tubes(robot), rotations, translations, tips, make_scratch(n)
    )
    return ConcentricTubeMotion(share < 1.0, float(share), tips[:count] - offset)
