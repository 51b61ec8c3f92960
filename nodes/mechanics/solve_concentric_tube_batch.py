"""Many configurations of one concentric tube robot at once."""

import numpy as np
from jaxtyping import Float

from nodes.mechanics.concentric_tube_arrays import (
    bent_backwards,
    make_outcomes,
    make_scratch,
    to_tubes,
    with_ghost,
)
from nodes.mechanics.concentric_tube_solution import ConcentricTubeBatch
from nodes.mechanics.robots import ConcentricTubeRobot


def solve_concentric_tube_batch(
    robot: ConcentricTubeRobot,
    rotations_rad: Float[np.ndarray, "k tube"],
    translations_mm: Float[np.ndarray, "k tube"],
    tip_angles_rad: Float[np.ndarray, "k tube"] | None = None,
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
    """
    from nodes.kernels.ctr_outcomes import Joints
    from nodes.kernels.ctr_solve import solve_rows

    tubes, count = to_tubes(robot), len(robot.tubes)
    offset = bent_backwards(robot)
    translations = with_ghost(translations_mm)
    start = np.empty((0, count)) if tip_angles_rad is None else tip_angles_rad + offset
    joints = Joints(with_ghost(rotations_rad + offset), translations, with_ghost(start))
    n = translations.shape[1]
    outcomes = make_outcomes(len(translations), n, samples, with_uniqueness, with_jacobian)
    if samples:
        tip = np.maximum(translations[:, :1] + tubes.length[0], 0.0)
        outcomes.places[:] = np.linspace(0.0, 1.0, samples) * tip
    size, columns = (0.0,) * (n - 1), (0.0,) * (n * (n - 1))
    solve_rows(size, columns, tubes, joints, 0, len(translations), make_scratch(n), outcomes)
    patient_from_base = robot.patient_from_base
    rotation = patient_from_base[:3, :3]
    kept = list(range(count)) + list(range(n, n + count))
    return ConcentricTubeBatch(
        outcomes.status,
        outcomes.tips[:, :count] - offset,
        outcomes.entries[:, :count] - offset,
        outcomes.twists[:, :count].copy(),
        patient_from_base @ _to_poses(outcomes.frame),
        outcomes.determinant,
        outcomes.residual,
        outcomes.least,
        outcomes.least > 0.0,
        _turn_jacobian(rotation, outcomes.jacobian[:, :, kept]),
        outcomes.places,
        outcomes.points @ rotation.T + patient_from_base[:3, 3],
    )


def _to_poses(frames: Float[np.ndarray, "k 12"]) -> Float[np.ndarray, "k 4 4"]:
    poses = np.zeros((len(frames), 4, 4))
    poses[:, :3, :3], poses[:, :3, 3] = frames[:, :9].reshape(-1, 3, 3), frames[:, 9:]
    poses[:, 3, 3] = 1.0
    return poses


def _turn_jacobian(
    rotation: Float[np.ndarray, "3 3"], jacobian: Float[np.ndarray, "k 6 joints"]
) -> Float[np.ndarray, "k 6 joints"]:
    """Return the same in patient axes."""
    k, _, joints = jacobian.shape
    return (rotation @ jacobian.reshape(k, 2, 3, joints)).reshape(k, 6, joints)
