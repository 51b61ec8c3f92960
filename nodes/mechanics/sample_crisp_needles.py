"""Points along all needles of solved straight, unloaded CRISP robots, many at once."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from nodes.mechanics.crisp_lane_groups import (
    Motion,
    gather_rows,
    lay_motion,
    lay_rows,
    pose_problem,
)
from nodes.mechanics.robots import CrispSetup


class NeedlePoints(NamedTuple):
    """Points in patient LPS mm, from the entry points on.

    tool_patient_mm : (robot, joints * pieces + 2, 3): entry point, the ends of equal pieces of what
    lies before each joint, tip; beyond the last joint the tool is straight.
    snares_patient_mm : (robot, joint, pieces + 1, 3), joints sorted along the tool.
    """

    tool_patient_mm: np.ndarray
    snares_patient_mm: np.ndarray


def sample_crisp_needles(
    setup: CrispSetup,
    orientations: Float[np.ndarray, "robot needle 3 3"],
    lengths_mm: Float[np.ndarray, "robot needle"],
    wrenches: Float[np.ndarray, "robot needle 6"],
    pieces: int,
) -> NeedlePoints:
    """Return points along needles; each piece is one step of order 8.

    Parameters
    ----------
    orientations : patient_from_entry of each needle.
    wrenches : of a solution: moment, N mm, and force, N, at the entry points, patient axes.
    pieces : into how many each snare and each part of the tool before a joint is cut.
    """
    from nodes.kernels.crisp_lanes import make_lanes
    from nodes.kernels.crisp_straight_rod import ROD_ROWS
    from nodes.kernels.crisp_straight_samples import sample_groups

    problem = pose_problem(setup, lengths_mm)
    count, joints = len(lengths_mm), len(problem.robot.snare)
    still = np.zeros_like(lengths_mm)
    motion = Motion(
        orientations, np.zeros((*still.shape, 3)), lengths_mm, still,
        wrenches[:, problem.robot.snare] / problem.wrench_unit, np.zeros(count, int),
    )  # fmt: skip
    poses, _ = lay_motion(problem, motion)
    groups = len(poses.lengths)
    tools = make_lanes(groups, 3 * (joints * pieces + 2))
    snares = make_lanes(groups, joints, 3 * (pieces + 1))
    laid = lay_rows(motion.wrenches.reshape(count, -1))
    sample_groups(problem.robot, poses, laid, tools, snares, make_lanes(ROD_ROWS))
    flat = snares.reshape(groups, -1, snares.shape[-1])
    places = [
        gather_rows(points[:, None], count).reshape(count, -1, 3) * problem.unit_mm
        + setup.entry_points_patient_mm[0]
        for points in (tools, flat)
    ]
    return NeedlePoints(places[0], places[1].reshape(count, joints, pieces + 1, 3))
