"""Straight CRISP robots in lanes, of random numbers."""

import numpy as np
from scipy.spatial.transform import Rotation

from nodes.kernels.crisp_lanes import LANES, make_lanes
from nodes.kernels.crisp_straight_residual import SITE_ROWS, Pose, Robot, Workspace
from nodes.kernels.crisp_straight_rod import ROD_ROWS


def random_robot(seed, rigid):
    """Return robot, pose, wrenches and workspace; every lane is another robot."""
    rng, joints = np.random.default_rng(seed), len(rigid)
    needles = joints + 1
    robot = Robot(
        rng.uniform(0.5, 1.5, needles),
        rng.uniform(0.4, 1.2, needles),
        rng.normal(size=(needles, 3)),
        rng.permutation(joints) + 1,
        np.array(rigid, bool),
        rng.uniform(-0.3, 0.3, joints),
    )
    pose = Pose(make_lanes(6 * needles), make_lanes(needles), make_lanes(joints))
    for lane in range(LANES):
        frames = Rotation.random(needles, rng=rng).as_matrix()
        pose.frames[:, lane] = frames[:, :, [2, 0]].transpose(0, 2, 1).ravel()
    pose.lengths[:] = rng.uniform(0.7, 1.3, (needles, LANES))
    pose.grasps[:] = np.sort(rng.uniform(0.2, 0.7, (joints, LANES)), axis=0)
    wrenches = make_lanes(6 * joints)
    wrenches[:] = rng.normal(size=wrenches.shape)
    sites = SITE_ROWS * joints
    work = Workspace(make_lanes(ROD_ROWS), make_lanes(sites), make_lanes(sites), make_lanes(9))
    return robot, pose, wrenches, work
