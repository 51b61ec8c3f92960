"""Cosserat rods of a CRISP robot, slowly: from base wrenches to what its grasps leave open.

[Kuntz2017] Sec. IV-B and [Anderson2017] appendix A as they stand there: place, quaternion, moment
and force of every rod, integrated with DOP853 from entry point to tip, in many columns at once and
in complex numbers where derivatives are sought. Nothing here is shared with the project's solver.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from nodes.mechanics.robots import CrispConfiguration, CrispSetup

TIGHT, LOOSE = 1e-12, 1e-5  # relative tolerances of the integration


@dataclass(frozen=True)
class Joint:
    """The tip of a rod at a place on the tool, mm from the tool's entry point."""

    snare: int
    arc: float
    rigid: bool
    cosine: float


@dataclass(frozen=True)
class Robot:
    """Setup and configuration as numbers, the tool first."""

    stiffness: np.ndarray  # (rod, 3) E I, E I, G J, N mm^2
    precurvature: np.ndarray
    entry: np.ndarray
    frames: np.ndarray
    lengths: np.ndarray
    joints: tuple[Joint, ...]
    loads: tuple[tuple[float, np.ndarray, np.ndarray], ...]

    @property
    def scale(self) -> np.ndarray:
        """Return (6,) what a moment and a force of ordinary size are here, N mm and N."""
        moment = self.stiffness[0, 0] / self.lengths[0]
        return np.repeat([moment, moment / self.lengths[0]], 3)


def robot_of(setup: CrispSetup, configuration: CrispConfiguration) -> Robot:
    """Return the numbers of a setup in a configuration."""
    stiffness = []
    for needle in setup.needles:
        second = np.pi * (needle.outer_diameter_mm**4 - needle.inner_diameter_mm**4) / 64
        young, poisson = needle.material.young_modulus_mpa, needle.material.poisson_ratio
        bending = young * second
        stiffness.append((bending, bending, young / (2 * (1 + poisson)) * 2 * second))
    tool = configuration.lengths_mm[0]
    joints = [
        Joint(
            snare.needle,
            tool - snare.grasp_mm if snare.measured_from == "tip" else snare.grasp_mm,
            snare.joint == "rigid",
            snare.cosine,
        )
        for snare in setup.snares
    ]
    return Robot(
        np.array(stiffness),
        np.array([needle.precurvature_per_mm for needle in setup.needles]),
        setup.entry_points_patient_mm,
        configuration.patient_from_entry,
        configuration.lengths_mm,
        tuple(sorted(joints, key=lambda joint: joint.arc)),
        tuple((load.arc_length_mm, load.force_n, load.moment_n_mm) for load in configuration.loads),
    )


def frame_of(quaternion):
    """Return (3, 3, k) rotations of (4, k) unit quaternions w, x, y, z."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_of(frame):
    """Return w, x, y, z of a rotation: the eigenvector of Bar-Itzhack's symmetric matrix."""
    r = frame
    matrix = np.array(
        [
            [r[0, 0] + r[1, 1] + r[2, 2], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [0, r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [0, 0, r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1]],
            [0, 0, 0, r[2, 2] - r[0, 0] - r[1, 1]],
        ]
    )
    return np.linalg.eigh(matrix, UPLO="U")[1][:, -1]


def cross(a, b):
    """Return the vector product along the first axis, of complex numbers too."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def dot(a, b):
    """Return the product without conjugation, which complex steps need."""
    return (a * b).sum(0)


def _rate(stiffness, precurvature):
    """Return d/ds of (place, quaternion, moment, force, elastic energy) in many columns at once."""

    def rate(_, flat):
        state = flat.reshape(14, -1)
        quaternion, moment, force = state[3:7], state[7:10], state[10:13]
        frame = frame_of(quaternion)
        own = np.einsum("ijk,ik->jk", frame, moment)
        strain = own / stiffness[:, None]
        bend = strain + precurvature[:, None]
        turn = np.concatenate(
            [
                -dot(quaternion[1:], bend)[None],
                quaternion[0] * bend + cross(quaternion[1:], bend),
            ]
        )
        tangent = frame[:, 2]
        still = np.zeros_like(force)
        return np.concatenate(
            [tangent, turn / 2, -cross(tangent, force), still, dot(own, strain)[None] / 2]
        ).ravel()

    return rate


def _integrate(robot, rod, state, begin, end, tolerance):
    """Return the state at the end of a piece of a rod, and the piece."""
    found = solve_ivp(
        _rate(robot.stiffness[rod], robot.precurvature[rod]),
        (begin, end),
        state.ravel(),
        "DOP853",
        rtol=tolerance,
        atol=1e-2 * tolerance,
        dense_output=True,
    )
    return found.y[:, -1].reshape(14, -1), found.sol


def _start(robot, rod, wrenches):
    columns = wrenches.shape[1]
    fixed = np.concatenate([robot.entry[rod], quaternion_of(robot.frames[rod])])
    wrench = wrenches[6 * rod : 6 * rod + 6]
    return np.concatenate(
        [np.repeat(fixed[:, None], columns, 1).astype(wrench.dtype), wrench, 0 * wrench[:1]]
    )


def shoot(robot: Robot, wrenches: np.ndarray, tolerance: float = TIGHT):
    """Integrate all rods from base wrenches; return the equations' values, end states and pieces.

    Parameters
    ----------
    wrenches : (6 rod, k) base wrenches in columns, moment first, N mm and N.

    Returns
    -------
    equations : (6 rod, k) grasp by grasp, then moment and force at the tool's tip; mm, N mm, N.
    ends : states at the rods' tips, the tool first.
    pieces : of each rod, continuous states between its joints and loads.
    """
    ends, pieces = [], []
    for rod in range(1, len(robot.lengths)):
        end, piece = _integrate(
            robot, rod, _start(robot, rod, wrenches), 0.0, robot.lengths[rod], tolerance
        )
        ends.append(end)
        pieces.append([piece])
    tool, equations, tool_pieces = _shoot_tool(robot, wrenches, ends, tolerance)
    equations.append(tool[7:13])
    return np.concatenate(equations), [tool, *ends], [tool_pieces, *pieces]


def _shoot_tool(robot, wrenches, snares, tolerance):
    state, here = _start(robot, 0, wrenches), 0.0
    stations = [(joint.arc, joint, None) for joint in robot.joints]
    stations += [(load[0], None, load) for load in robot.loads]
    equations, pieces = [], []
    for arc, joint, load in [*sorted(stations, key=lambda s: s[0]), (robot.lengths[0], None, None)]:
        if arc > here:
            state, piece = _integrate(robot, 0, state, here, arc, tolerance)
            pieces.append(piece)
            here = arc
        if load is not None:
            state = state.copy()
            state[7:10] -= load[2][:, None]
            state[10:13] -= load[1][:, None]
        if joint is not None:
            snare = snares[joint.snare - 1]
            equations.append(_grasp(joint, state, snare))
            state = _hand_over(joint, state, snare)
    return state, equations, pieces


def _grasp(joint, tool, snare):
    """Return six numbers that vanish where the snare holds the tool as this joint does."""
    tool_frame, snare_frame = frame_of(tool[3:7]), frame_of(snare[3:7])
    apart = tool[:3] - snare[:3]
    if joint.rigid:  # [Kuntz2017] eq. (6): the snare's x, -z, y lie along the tool's x, y, z
        turned = np.stack([snare_frame[:, 0], -snare_frame[:, 2], snare_frame[:, 1]], 1)
        return np.concatenate([apart, sum(cross(tool_frame[:, i], turned[:, i]) for i in range(3))])
    tangents, moment = (tool_frame[:, 2], snare_frame[:, 2]), snare[7:10]
    rest = [dot(*tangents) - joint.cosine, dot(tangents[1], moment), dot(tangents[0], moment)]
    return np.concatenate([apart, np.array(rest)])


def _hand_over(joint, tool, snare):
    """Return the tool's state beyond a joint, [Anderson2017] eq. (20), (21)."""
    moment = snare[7:10]
    if not joint.rigid:  # only what acts about the common normal passes
        normal = cross(frame_of(tool[3:7])[:, 2], frame_of(snare[3:7])[:, 2])
        moment = normal * dot(normal, moment) / dot(normal, normal)
    beyond = tool.copy()
    beyond[7:10] += moment
    beyond[10:13] += snare[10:13]
    return beyond
