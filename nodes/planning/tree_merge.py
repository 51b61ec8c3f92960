"""Several trees from one start made one."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Int

from nodes.mechanics.crisp_lane_groups import Problem
from nodes.mechanics.shapes import Figure
from nodes.planning.artefacts import CrispTree, Ending, PlacedSetup

if TYPE_CHECKING:
    from nodes.planning.tree_growth import Growth

COUNTED = (
    (
        "steps without a solution",
        "edges that ended since their next step has none on the branch followed",
    ),
    ("touches anatomy", "edges that ended before a needle would touch anatomy"),
    ("needles touch", "edges that ended before needles would touch one another"),
    ("sheath touches bone", "edges that ended before a sheath would touch bone"),
    ("bends too much", "edges that ended before a needle would bend more than it may"),
    ("folds", "edges refused where the branch of equilibria folds and the robot would snap"),
    ("steps solved", "configurations solved on edges"),
    ("steps tested", "of those, tested for touching anything"),
    ("edges", "edges tried, each towards a configuration drawn at random"),
    ("complete edges", "edges that came as far as they were meant to"),
    ("barren edges", "edges of which not even the first step was valid"),
    ("tilts too far", "edges that ended before a needle would tilt more than it may"),
)


def merge_trees(
    placed: PlacedSetup,
    problem: Problem,
    growths: list["Growth"],
    began: float,
    ending: Ending,
) -> CrispTree:
    """Return one tree: the common start, then nodes in turns, as they are numbered in their own."""
    sizes = [int(growth.nodes.size[0]) for growth in growths]
    numbers = np.concatenate([np.arange(1, size) for size in sizes])
    trees = np.repeat(np.arange(len(sizes)), np.array(sizes) - 1)
    order = np.lexsort((trees, numbers))
    places = _find_places(sizes, order)
    nodes = [growth.nodes for growth in growths]
    wrenches = _gather([one.wrenches for one in nodes], sizes, order)
    tips = _gather([one.tips for one in nodes], sizes, order)
    parents = [place[one.parents[: len(place)]] for place, one in zip(places, nodes, strict=True)]
    seconds = [_find_seconds(growth, began) for growth in growths]
    merged_parents = _gather(parents, sizes, order)
    merged_parents[0] = -1
    return CrispTree(
        placed,
        merged_parents,
        _gather([one.quaternions for one in nodes], sizes, order),
        _gather([one.lengths for one in nodes], sizes, order),
        _gather([one.steps for one in nodes], sizes, order),
        problem.to_wrenches(wrenches.reshape(len(wrenches), -1, 6)),
        tips[:, :3] * problem.unit_mm + placed.setup.entry_points_patient_mm[0],
        np.array(tips[:, 3:6]),
        _gather(seconds, sizes, order),
        np.concatenate([[0], trees[order]]),
        _find_first([growth.sights.seeing for growth in growths], places),
        ending,
        _count(growths),
    )


def _gather(
    arrays: list[np.ndarray], sizes: list[int], order: Int[np.ndarray, "later"]
) -> np.ndarray:
    """Return what all trees have of their nodes: of the start, then of all others in order."""
    later = [array[1:size] for array, size in zip(arrays, sizes, strict=True)]
    return np.concatenate([arrays[0][:1], np.concatenate(later)[order]])


def _find_places(sizes: list[int], order: Int[np.ndarray, "later"]) -> list[np.ndarray]:
    """Return for each tree where its nodes are in the one tree."""
    places = np.empty(len(order), int)
    places[order] = 1 + np.arange(len(order))
    ends = np.cumsum(np.array(sizes) - 1)
    return [np.concatenate([[0], own]) for own in np.split(places, ends[:-1])]


def _find_seconds(growth: "Growth", began: float) -> Float[np.ndarray, "node"]:
    """Return when each node was there; the time between two looks at the clock is shared evenly."""
    times = np.concatenate([[0.0], np.array(growth.times) - began])
    counts = np.concatenate([[1], growth.counts])
    return np.interp(np.arange(1, counts[-1] + 1), counts, times)


def _find_first(seeing: list[np.ndarray], places: list[np.ndarray]) -> Int[np.ndarray, "cell"]:
    """Return the first node of the one tree that sees each cell, or -1."""
    none = np.iinfo(int).max
    first = np.full(len(seeing[0]), none)
    for own, place in zip(seeing, places, strict=True):
        first = np.minimum(first, np.where(own >= 0, place[own], none))
    return np.where(first < none, first, -1)


def _count(growths: list["Growth"]) -> tuple[Figure, ...]:
    totals = np.sum([growth.room.counts for growth in growths], axis=0)
    iterations = sum(growth.room.solver.iterations.sum() for growth in growths)
    return (
        *(
            Figure(name, float(total), "", meaning)
            for (name, meaning), total in zip(COUNTED, totals, strict=True)
        ),
        Figure("iterations", float(iterations), "", "changes of wrenches to solve steps"),
    )
