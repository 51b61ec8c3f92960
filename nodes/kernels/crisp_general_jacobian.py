"""Derivatives of a whole CRISP robot by all that can change about it.

Columns: base wrenches (6 n), for each rod its base's rotation vector and its length (4 n), entry
points (3 n), cosines (k), places of the grasps (k), loads' moments and forces (6 l).
"""

from numba import njit

from nodes.kernels.crisp_general import new_walk, walk_robot, walk_to_tip
from nodes.kernels.crisp_general_problem import RIGID
from nodes.kernels.crisp_options import OUTER


@njit(**OUTER)
def differentiate(crisp, wrench, from_tip, reach):
    """Return a walk with all columns and the camera's rows.

    Parameters
    ----------
    from_tip : (k,) bool, whether a grasp moves with the tool's insertion.

    Returns
    -------
    residual : (6 n,).
    rows : (6 n, c) of the residual.
    camera : (6, c) dp and rotation vector of the tool's tip, world axes.
    joints : (k, 6, c) the same of the tool at the joints.
    """
    n, k, loads = len(wrench), len(crisp.joints), len(crisp.loads)
    columns = 13 * n + 2 * k + 6 * loads
    walk = new_walk(crisp, columns)
    for rod in range(n):
        for i in range(6):
            walk.changes[rod, 6 + i, 6 * rod + i] = 1.0
        for i in range(3):
            walk.changes[rod, 3 + i, 6 * n + 4 * rod + i] = 1.0
            walk.changes[rod, i, 10 * n + 3 * rod + i] = 1.0
        walk.slides[rod, 6 * n + 4 * rod + 3] = 1.0
    for joint in range(k):
        walk.slides[n + joint, 13 * n + k + joint] = 1.0
        if from_tip[joint]:
            walk.slides[n + joint, 6 * n + 3] = 1.0
    walk_robot(crisp, wrench, reach, walk, columns)
    for joint in range(k):
        if crisp.joints[joint, RIGID] == 0:
            walk.rows[6 + 6 * joint + 3, 13 * n + joint] -= 1.0
    walk_to_tip(crisp, reach, walk, columns)
    return walk.residual, walk.rows, walk.changes[0, :6].copy(), walk.passed
