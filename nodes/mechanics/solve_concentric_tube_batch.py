"""Many configurations of one concentric tube robot at once."""

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.mechanics.concentric_tube_arrays import (
    bent_backwards,
    make_outcomes,
    make_scratch,
    to_tubes,
    with_ghost,
)
from nodes.mechanics.concentric_tube_solution import ConcentricTubeBatch
from nodes.mechanics.robots import ConcentricTubeRobot

Rows = Float[np.ndarray, "_ _"]  # (k, tube), which `_check_rows` refuses better than a type does


def solve_concentric_tube_batch(
    robot: ConcentricTubeRobot,
    rotations_rad: Rows,
    translations_mm: Rows,
    tip_angles_rad: Rows | None = None,
    samples: int = 0,
    with_uniqueness: bool = False,
    with_jacobian: bool = False,
) -> ConcentricTubeBatch:
    """Solve configurations of one robot, each from its own tip angles or from none.

    Torsionally compliant and unloaded, after [Dupont2010] and [Rucker2010]; tips to 1e-6 mm. A
    configuration whose bases or tips are out of order has the status "no solution"; the robot's
    limits are not looked at.

    Parameters
    ----------
    rotations_rad, translations_mm : (k, tube) theta and beta, innermost tube first.
    tip_angles_rad : (k, tube) of near configurations, whose branch is kept; None to start cold.
    samples : points of the backbone wanted, evenly from the entry to the tip; 0 for none.
    with_uniqueness : whether to find out if each insertion has one solution for every rotation.
    with_jacobian : whether to find the tip's Jacobian.

    Raises
    ------
    BadInput if the arrays have not one row for each configuration and one value for each tube.
    """
    from nodes.kernels.ctr_outcomes import Joints
    from nodes.kernels.ctr_solve import solve_rows

    _check_rows(robot, rotations_rad, translations_mm, tip_angles_rad)
    tubes, count = to_tubes(robot), len(robot.tubes)
    offset = bent_backwards(robot)
    translations = with_ghost(translations_mm)
    start = np.empty((0, count)) if tip_angles_rad is None else tip_angles_rad + offset
    joints = Joints(with_ghost(rotations_rad + offset), translations, with_ghost(start))
    n = translations.shape[1]
    outcomes = make_outcomes(len(translations), n, samples, with_uniqueness, with_jacobian)
    size, columns = (0.0,) * (n - 1), (0.0,) * (n * (n - 1))
    scratch = make_scratch(n, samples=samples)
    solve_rows(size, columns, tubes, joints, 0, len(translations), scratch, outcomes)
    kept = list(range(count)) + list(range(n, n + count))
    return ConcentricTubeBatch(
        outcomes.status,
        outcomes.tips[:, :count] - offset,
        outcomes.entries[:, :count] - offset,
        outcomes.twists[:, :count].copy(),
        _to_poses(outcomes.frame),
        outcomes.determinant,
        outcomes.residual,
        outcomes.least,
        outcomes.least > 0.0,
        outcomes.jacobian[:, :, kept],
        outcomes.places,
        outcomes.points,
    )


def _check_rows(
    robot: ConcentricTubeRobot,
    rotations: np.ndarray,
    translations: np.ndarray,
    tips: np.ndarray | None,
) -> None:
    """Raise BadInput unless all arrays are alike: kernels would read beyond a short one."""
    given = {"rotations_rad": rotations, "translations_mm": translations}
    given |= {} if tips is None else {"tip_angles_rad": tips}
    wanted = (len(rotations), len(robot.tubes))
    for name, values in given.items():
        if values.shape != wanted:
            raise BadInput(
                f"{name} of shape {values.shape}",
                f"{wanted[0]} configurations of {wanted[1]} tubes have shape {wanted}",
                "give one row for each configuration, one column for each tube",
            )


def _to_poses(frames: Float[np.ndarray, "k 12"]) -> Float[np.ndarray, "k 4 4"]:
    poses = np.zeros((len(frames), 4, 4))
    poses[:, :3, :3], poses[:, :3, 3] = frames[:, :9].reshape(-1, 3, 3), frames[:, 9:]
    poses[:, 3, 3] = 1.0
    return poses
