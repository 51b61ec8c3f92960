"""One configuration of a concentric tube robot: shape, branch, Jacobian, stability."""

import numpy as np
from jaxtyping import Float

from nodes.mechanics.check_robots import check_concentric_tube_configuration
from nodes.mechanics.concentric_tube_arrays import (
    bent_backwards,
    make_scratch,
    to_tubes,
    with_ghost,
)
from nodes.mechanics.concentric_tube_solution import (
    STATUSES,
    ConcentricTubeBatch,
    ConcentricTubeSolution,
)
from nodes.mechanics.robots import ConcentricTubeConfiguration, ConcentricTubeRobot
from nodes.mechanics.solve_concentric_tube_batch import solve_concentric_tube_batch

Places = Float[np.ndarray, "n"]


def solve_concentric_tubes(
    robot: ConcentricTubeRobot,
    configuration: ConcentricTubeConfiguration,
    tip_angles_rad: Float[np.ndarray, "tube"] | None = None,
    arc_lengths_mm: Places | None = None,
) -> ConcentricTubeSolution:
    """Solve one configuration.

    Without tip angles it is solved from nothing: where the insertion has one solution for every
    rotation this is it, elsewhere it is one of several stable ones, and motion may lead to another.

    Parameters
    ----------
    tip_angles_rad : (tube,) of a near configuration, whose branch is kept.
    arc_lengths_mm : (n,) rising, where points are wanted, mm from the entry; None for entry and
        tip. Those beyond the tip are left out; entry, breaks and tip are added.

    Raises
    ------
    BadInput if the robot cannot take the configuration.
    """
    check_concentric_tube_configuration(robot, configuration)
    batch = solve_concentric_tube_batch(
        robot,
        configuration.rotations_rad[None],
        configuration.translations_mm[None],
        None if tip_angles_rad is None else tip_angles_rad[None],
        with_uniqueness=True,
        with_jacobian=True,
    )
    wanted = np.empty(0) if arc_lengths_mm is None else arc_lengths_mm
    return _solution(robot, configuration, batch, wanted)


def _solution(
    robot: ConcentricTubeRobot,
    configuration: ConcentricTubeConfiguration,
    batch: ConcentricTubeBatch,
    wanted: Float[np.ndarray, "w"],
) -> ConcentricTubeSolution:
    status, tips = STATUSES[batch.status[0]], batch.tip_angles_rad[0]
    found = status in ("solved", "unstable")
    places, frames, angles = _trace(robot, configuration, tips, wanted if found else wanted[:0])
    if not found:
        places, frames, angles = places[:0], frames[:0], angles[:0]
    return ConcentricTubeSolution(
        status=status,
        reason=_REASONS[status],
        tip_angles_rad=tips,
        entry_angles_rad=batch.entry_angles_rad[0],
        entry_twists_per_mm=batch.entry_twists_per_mm[0],
        patient_from_tip=batch.patient_from_tip[0],
        tip_jacobian=batch.tip_jacobian[0],
        determinant=float(batch.determinant[0]),
        least_determinant=float(batch.least_determinant[0]),
        one_solution=bool(batch.one_solution[0]),
        residual_rad=float(batch.residual_rad[0]),
        arc_lengths_mm=places,
        points_patient_mm=frames[:, 9:],
        tangents=frames[:, 2:9:3],
        angles_rad=angles,
    )


_REASONS = {
    "solved": "",
    "no solution": "the bases or tips of the tubes are out of order",
    "not converged": "no tip angles were found that belong to these rotations; start from those of"
    " a near configuration",
    "unstable": "the tubes are balanced, but would snap away at the slightest push",
}


def _trace(
    robot: ConcentricTubeRobot,
    configuration: ConcentricTubeConfiguration,
    tips: Float[np.ndarray, "tube"],
    wanted: Float[np.ndarray, "w"],
) -> tuple[Places, Float[np.ndarray, "n 12"], Float[np.ndarray, "n tube"]]:
    """Return places from entry to tip, innermost tube's frames and positions, angles there."""
    from nodes.kernels.ctr_outcomes import Joints
    from nodes.kernels.ctr_trace import trace

    tubes, offset, count = to_tubes(robot), bent_backwards(robot), len(robot.tubes)
    translations = with_ghost(configuration.translations_mm[None])
    rotations = with_ghost((configuration.rotations_rad + offset)[None])
    n = translations.shape[1]
    scratch = make_scratch(n, len(wanted))
    angles = np.zeros((len(scratch.nodes.place), n))
    joints = Joints(rotations, translations, np.empty((0, n)))
    tips = with_ghost((tips + offset)[None])[0]
    size, columns = (0.0,) * (n - 1), (0.0,) * (n * (n - 1))
    steps = trace(size, columns, tubes, joints, tips, np.array(wanted), scratch, angles)
    upward = slice(steps, None, -1)
    return (
        scratch.nodes.place[upward].copy(),
        scratch.nodes.frame[upward].copy(),
        angles[upward, :count] - offset,
    )
