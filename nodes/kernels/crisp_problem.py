"""A CRISP robot as kernels take it: the tool is rod 0, grasps are sorted along it."""

from typing import NamedTuple

import numpy as np


class Rods(NamedTuple):
    """What does not change while the robot moves.

    bending, torsion : (n,) E I and G J, N mm^2.
    precurvature : (n, 3) curvature in body axes when unloaded, 1/mm.
    entry : (n, 3) mm.
    """

    bending: np.ndarray
    torsion: np.ndarray
    precurvature: np.ndarray
    entry: np.ndarray


class Grasps(NamedTuple):
    """Joints, sorted by arc length on the tool.

    snare : (k,) int64, rod whose tip grasps.
    arc : (k,) place on the tool from its entry point, mm.
    rigid : (k,) bool.
    cosine : (k,) between the tangents at a relaxed joint.
    """

    snare: np.ndarray
    arc: np.ndarray
    rigid: np.ndarray
    cosine: np.ndarray


class Loads(NamedTuple):
    """Point loads on the tool, sorted by arc length: arc (l,) mm, force (l, 3) N, moment (l, 3)
    N mm, in world axes."""

    arc: np.ndarray
    force: np.ndarray
    moment: np.ndarray
