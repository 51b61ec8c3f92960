"""How far each tube of a concentric tube robot is bent from the curve of its own."""

import numpy as np
from jaxtyping import Bool, Float

from nodes.mechanics.concentric_tube_solution import ConcentricTubeSolution
from nodes.mechanics.robots import ConcentricTubeConfiguration, ConcentricTubeRobot

PerTube = Float[np.ndarray, "tube"]


def largest_strains(
    robot: ConcentricTubeRobot,
    configuration: ConcentricTubeConfiguration,
    solution: ConcentricTubeSolution,
) -> PerTube:
    """Return each tube's largest bending strain: its radius times its change of curvature.

    Nested tubes share the curvature sum_j EI_j kappa_j (cos, sin)(psi_j) / sum_j EI_j over the
    tubes that are there, straight parts included [Dupont2010]. Behind the entry all are straight.
    Between samples the set of tubes is the same, so each is looked at from both of its sides.
    """
    tubes = robot.tubes
    kappa = np.array([tube.curvature_per_mm for tube in tubes])
    bases = configuration.translations_mm
    starts = bases + [tube.straight_length_mm for tube in tubes]
    tips = bases + [tube.length_mm for tube in tubes]
    drawn_in = (starts < 0) & (tips > starts)
    largest = np.where(drawn_in, abs(kappa), 0.0)
    arcs, angles = solution.arc_lengths_mm, solution.angles_rad
    middle = (arcs[1:, None] + arcs[:-1, None]) / 2
    there, curved = middle < tips, (middle < tips) & (middle > starts)
    for side in (angles[:-1], angles[1:]):
        change = _changes(robot, kappa, side, there, curved)
        largest = np.maximum(largest, change.max(axis=0, initial=0.0))
    return largest * [tube.radius_mm for tube in tubes]


def _changes(
    robot: ConcentricTubeRobot,
    kappa: PerTube,
    angles: Float[np.ndarray, "n tube"],
    there: Bool[np.ndarray, "n tube"],
    curved: Bool[np.ndarray, "n tube"],
) -> Float[np.ndarray, "n tube"]:
    """Return how far each tube that is there is from its own curvature, 1/mm."""
    stiffness = np.where(there, [tube.bending_stiffness for tube in robot.tubes], 0.0)
    own = np.where(curved, kappa, 0.0)[..., None] * np.stack([np.cos(angles), np.sin(angles)], -1)
    shared = (stiffness[..., None] * own).sum(axis=1) / stiffness.sum(axis=1)[:, None]
    return np.where(there, np.linalg.norm(shared[:, None] - own, axis=-1), 0.0)
