"""The two mechanics as a person would first write them: SciPy's integrator inside SciPy's root."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

from nodes.mechanics.robots import ConcentricTubeConfiguration, ConcentricTubeRobot
from tests.nodes.mechanics.oracle_concentric_tubes import sections, stiffness
from tests.nodes.mechanics.oracle_crisp_rods import Robot, quaternion_of


def solve_concentric_plainly(
    robot: ConcentricTubeRobot, configuration: ConcentricTubeConfiguration, tolerance: float
) -> np.ndarray | None:
    """Return the tip (3,) in base axes: shooting over the twists at the base."""
    bending, torsion = stiffness(robot)
    cuts = sections(robot, configuration.translations_mm)
    count = len(bending)

    def shoot(twists):
        angles = configuration.rotations_rad - configuration.translations_mm * twists
        state = np.concatenate([angles, twists, np.zeros(3), np.eye(3).ravel()])
        for cut in cuts:
            stiff = np.where(cut.present, bending, 0.0)

            def rate(_, y, cut=cut, stiff=stiff):
                angles, twists, frame = y[:count], y[count : 2 * count], y[-9:].reshape(3, 3)
                pull = stiff * cut.curvature / stiff.sum()
                c, s = pull @ np.cos(angles), pull @ np.sin(angles)
                drive = cut.curvature * (np.sin(angles) * c - np.cos(angles) * s)
                turn = np.array([[0, 0, c], [0, 0, s], [-c, -s, 0.0]])
                twist_rate = cut.present * bending / torsion * drive
                turned = (frame @ turn).ravel()
                return np.concatenate([cut.present * twists, twist_rate, frame[:, 2], turned])

            way = (cut.begin, cut.end)
            state = solve_ivp(rate, way, state, rtol=tolerance, atol=tolerance).y[:, -1]
        return state

    found = root(lambda twists: 100 * shoot(twists)[count : 2 * count], np.zeros(count))
    return shoot(found.x)[-12:-9] if found.success else None


def solve_crisp_plainly(robot: Robot, start: np.ndarray, tolerance: float) -> np.ndarray | None:
    """Return the tip (3,): shooting over all base wrenches; relaxed joints alone."""
    size = np.tile(robot.scale, len(robot.lengths))

    def follow(rod, state, begin, end):
        soft, rest = 1 / robot.stiffness[rod], robot.precurvature[rod]

        def rate(_, y):
            w, x, y_, z = y[3:7]
            frame = _frame(y[3:7])
            bend = soft * (frame.T @ y[7:10]) + rest
            turn = np.array(
                [[-x, -y_, -z], [w, -z, y_], [z, w, -x], [-y_, x, w]],
            )
            moment = -np.cross(frame[:, 2], y[10:13])
            return np.concatenate([frame[:, 2], turn @ bend / 2, moment, np.zeros(3)])

        return solve_ivp(rate, (begin, end), state, rtol=tolerance, atol=tolerance).y[:, -1]

    def begin(rod, wrenches):
        return np.concatenate([robot.entry[rod], quaternion_of(robot.frames[rod]), wrenches[rod]])

    def shoot(unknown):
        wrenches = (unknown * size).reshape(-1, 6)
        tool, here, left = begin(0, wrenches), 0.0, []
        for joint in robot.joints:
            tool, here = follow(0, tool, here, joint.arc), joint.arc
            snare = follow(
                joint.snare, begin(joint.snare, wrenches), 0.0, robot.lengths[joint.snare]
            )
            tangents = np.stack([_frame(tool[3:7])[:, 2], _frame(snare[3:7])[:, 2]])
            rest = [tangents[0] @ tangents[1] - joint.cosine, *(tangents @ snare[7:10])]
            left += [*((tool - snare)[:3] / robot.lengths[0]), rest[0], *rest[1:]]
            tool[7:10] += snare[7:10] - np.linalg.pinv(tangents) @ (tangents @ snare[7:10])
            tool[10:13] += snare[10:13]
        tool = follow(0, tool, here, robot.lengths[0])
        return np.concatenate([left, tool[7:13] / robot.scale]), tool[:3]

    found = root(lambda x: shoot(x)[0], np.ravel(start) / size)
    return shoot(found.x)[1] if found.success else None


def _frame(quaternion):
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
