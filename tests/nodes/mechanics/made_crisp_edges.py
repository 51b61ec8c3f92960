"""Edges of CRISP robots that tests follow."""

import numpy as np
from scipy.spatial.transform import Rotation

from nodes.mechanics.crisp_edges import CrispEdges
from nodes.mechanics.parameters import FollowCrispEdgesParameters

PARAMETERS = FollowCrispEdgesParameters(
    tolerance_mm=1e-7,
    integration_error_mm=1e-8,
    largest_bend_rad=0.5,
    iterations=12,
    steps_between_checks=10,
    refinements=2,
)


def edges_from(frames, lengths, wrenches=None, count=1, steps=0, seed=0, step=1.0):
    """Return random edges from one configuration, each step of at most `step` mm and degrees."""
    rng, needles = np.random.default_rng(seed), len(lengths)
    turns = rng.normal(size=(count, needles, 3))
    turns *= rng.uniform(0, 1, (count, needles, 1)) / np.linalg.norm(turns, axis=2)[..., None]
    turned = Rotation.from_rotvec(np.radians(step * steps) * turns.reshape(-1, 3)).as_matrix()
    growths = step * steps * rng.uniform(-1, 1, (count, needles))
    wrenches = np.zeros((needles, 6)) if wrenches is None else wrenches
    return CrispEdges(
        np.repeat(frames[None], count, 0),
        turned.reshape(count, needles, 3, 3) @ frames,
        np.repeat(lengths[None], count, 0),
        lengths + growths,
        np.repeat(wrenches[None], count, 0),
        np.full(count, steps),
    )
