"""Derivatives of a CRISP robot in equilibrium by all that sets its shape."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from nodes.geometry.arrays import freeze_arrays
from nodes.kernels.crisp_general_problem import pack
from nodes.mechanics.robots import CrispConfiguration, CrispSetup
from nodes.mechanics.solve_crisp import step_turn, to_crisp


@dataclass(frozen=True)
class CrispJacobians:
    """Derivatives at an equilibrium; rows of poses are place (mm) and rotation vector (rad).

    Rotation vectors are in patient axes, of rows and columns alike: dR = [dphi]x R. Joints, cosines
    and loads come in their order along the tool, joints at one place in the setup's. Where a load
    or joint lies at the tool's tip or on another joint, the derivative is that of going on
    towards the tip.

    Parameters
    ----------
    camera_by_configuration : (6, 4 n) needle by needle: its base's rotation vector, its length; a
        snare that holds the tool's material moves with the tool's length, loads do not.
    camera_by_entry : (6, 3 n) entry points.
    camera_by_cosine : (6, k) cosines of the relaxed joints, zero for rigid ones.
    camera_by_grasp : (6, k) places of the joints on the tool, mm.
    camera_by_load : (6, 6 l) moment, force of each load.
    wrenches_by_configuration : (6 n, 4 n) base wrenches: a guess for a configuration near by.
    residual_by_wrenches : (6 n, 6 n) rows: moment and force at the tool's tip, then for each joint
        the gap (snare less tool), and rotation vector (rigid), or cosine and moments about the
        snare's and the tool's tangent (relaxed); columns: base wrenches, moment first.
    residual_by_configuration, residual_by_cosine, residual_by_load : (6 n, 4 n), (6 n, k),
        (6 n, 6 l) the same rows at held base wrenches.
    camera_by_wrenches, joints_by_wrenches : (6, 6 n), (k, 6, 6 n) poses of the tool's tip and of
        the tool at the joints, by the base wrenches, whether or not the joints then still hold.
    """

    camera_by_configuration: Float[np.ndarray, "6 joint_values"]
    camera_by_entry: Float[np.ndarray, "6 places"]
    camera_by_cosine: Float[np.ndarray, "6 k"]
    camera_by_grasp: Float[np.ndarray, "6 k"]
    camera_by_load: Float[np.ndarray, "6 load_values"]
    wrenches_by_configuration: Float[np.ndarray, "wrenches joint_values"]
    residual_by_wrenches: Float[np.ndarray, "wrenches wrenches"]
    residual_by_configuration: Float[np.ndarray, "wrenches joint_values"]
    residual_by_cosine: Float[np.ndarray, "wrenches k"]
    residual_by_load: Float[np.ndarray, "wrenches load_values"]
    camera_by_wrenches: Float[np.ndarray, "6 wrenches"]
    joints_by_wrenches: Float[np.ndarray, "k 6 wrenches"]

    def __post_init__(self) -> None:
        freeze_arrays(self)


def crisp_jacobians(
    setup: CrispSetup,
    configuration: CrispConfiguration,
    base_wrenches: Float[np.ndarray, "n 6"],
    tolerance_mm: float,
) -> CrispJacobians:
    """Return the derivatives at an equilibrium, exact to the integrator's error.

    With x the base wrenches, q what else sets the shape and r(x, q) = 0 at rest, dx/dq =
    -(dr/dx)^-1 dr/dq, and a pose c(x, q) changes by dc/dq + dc/dx dx/dq.

    Parameters
    ----------
    base_wrenches : (n, 6) of `solve_crisp`.
    tolerance_mm : error of the integrated shapes, mm.
    """
    from nodes.kernels.crisp_general_jacobian import differentiate

    crisp = to_crisp(setup, configuration)
    _, rows, camera, joints = differentiate(
        pack(crisp),
        np.array(base_wrenches),  # kernels are compiled once more for read-only arrays
        _move_with_tool(setup, crisp.grasps.snare),
        step_turn(crisp, tolerance_mm),
    )
    unknown = base_wrenches.size
    wrenches = np.linalg.solve(rows[:, :unknown], -rows[:, unknown:])
    total = camera[:, unknown:] + camera[:, :unknown] @ wrenches
    values, n, k = rows[:, unknown:], len(crisp.lengths), len(crisp.grasps.arc)
    ends = np.cumsum([4 * n, 3 * n, k, k])
    by_pose, by_entry, by_cosine, by_grasp, by_load = np.split(total, ends, axis=1)
    held = np.split(values, ends, axis=1)
    return CrispJacobians(
        by_pose,
        by_entry,
        by_cosine,
        by_grasp,
        by_load,
        wrenches[:, : 4 * n],
        rows[:, :unknown],
        held[0],
        held[2],
        held[4],
        camera[:, :unknown],
        joints[:, :, :unknown],
    )


def _move_with_tool(setup: CrispSetup, needles: np.ndarray) -> np.ndarray:
    """Return for each joint along the tool whether it moves with the tool's insertion."""
    held = {snare.needle: snare.measured_from == "tip" for snare in setup.snares}
    return np.array([held[int(needle)] for needle in needles], bool)
