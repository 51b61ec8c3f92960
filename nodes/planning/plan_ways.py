"""The way to one node of a tree: traced back, shortened, smoothed, cut evenly and verified."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from nodes.planning.artefacts import CrispMotion, CrispTree
from nodes.planning.plan_edges import (
    Ground,
    Walked,
    end_alike,
    find_valid,
    pick_ends,
    walk_edges,
)
from nodes.planning.plan_paths import Path, places_along, read_nodes, trace_back
from nodes.planning.plan_shortcuts import shorten_path, smooth_path

SeesIt = Callable[[Float[np.ndarray, "4 4"]], bool]  # of patient_from_camera


class Way(NamedTuple):
    """A motion that was verified; the way's length before it was shortened, mm, and after."""

    motion: CrispMotion
    found_mm: float
    length_mm: float


def plan_way(
    ground: Ground, tree: CrispTree, node: int, sees_it: SeesIt, rng: np.random.Generator
) -> Way | None:
    """Return a motion from the start towards a node that ends as soon as the goal is seen, or None
    where no motion proves to be valid.

    What was shortened and smoothed is verified with finer steps; if it fails, what was shortened
    alone, and at last the tree's own way.
    """
    found = _follow_tree(ground, tree, node, sees_it)
    if found is None:
        return None
    lever = ground.parameters.lever_mm
    before = float(places_along(found, lever)[-1])
    shortened = shorten_path(ground, found, rng)
    for path in (smooth_path(ground, shortened), shortened, found):
        motion = verify_path(ground, path, sees_it)
        if motion is not None:
            return Way(motion, before, _measure(motion, lever))
    return None


def _follow_tree(ground: Ground, tree: CrispTree, node: int, sees_it: SeesIt) -> Path | None:
    """Return the tree's way to a node, up to where the goal is first seen."""
    corners = read_nodes(tree, trace_back(tree.parents, node))
    path, poses = join_edges(ground, corners, 1)
    if path is None:
        return None
    seeing = (place for place, pose in enumerate(poses) if sees_it(pose))
    return path.until(next(seeing, len(poses) - 1))


def verify_path(ground: Ground, path: Path, sees_it: SeesIt) -> CrispMotion | None:
    """Return a way's motion, up to where the goal is first seen, if it is valid at finer steps.

    From corner to corner steps are of one size.
    """
    finer = ground.parameters.finer
    fine, poses = join_edges(ground, path, finer)
    if fine is None:
        return None
    for last in range(0, len(poses), finer):
        if sees_it(poses[last]):
            chosen = slice(0, last + 1, finer)
            return CrispMotion(
                fine.orientations[chosen],
                fine.lengths_mm[chosen],
                fine.wrenches[chosen],
                poses[chosen],
            )
    return None


def join_edges(ground: Ground, path: Path, finer: int) -> tuple[Path | None, np.ndarray]:
    """Return the way between the corners of another in finer steps, and patient_from_camera there;
    None if any of it is not valid."""
    chosen = path.corners
    if len(chosen) == 1:  # a way of no length
        chosen = np.repeat(chosen, 2)
    ends = pick_ends(path, chosen[:-1], chosen[1:])
    walked = walk_edges(ground, ends, finer)
    if not (find_valid(ground, walked).all() and end_alike(ground, ends, walked).all()):
        return None, np.zeros((0, 4, 4))
    return _chain(walked)


def _chain(walked: Walked) -> tuple[Path, np.ndarray]:
    """Return all edges one after the other; where they meet, one configuration."""
    edges = range(len(walked.counts))
    rows = [(edge, slice(int(edge > 0), walked.counts[edge] + 1)) for edge in edges]
    joined = Path(
        *(
            np.concatenate([values[row] for row in rows])
            for values in (walked.orientations, walked.lengths_mm, walked.wrenches)
        ),
        np.concatenate([[0], np.cumsum(walked.counts)]),
    )
    return joined, np.concatenate([walked.patient_from_camera[row] for row in rows])


def _measure(motion: CrispMotion, lever_mm: float) -> float:
    corners = np.arange(len(motion.lengths_mm))
    path = Path(motion.orientations, motion.lengths_mm, motion.wrenches, corners)
    return float(places_along(path, lever_mm)[-1])
