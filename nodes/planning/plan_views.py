"""Which nodes of trees show how much of a goal."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Int

from nodes.geometry.lines_of_sight import SurfaceCells, look
from nodes.planning.artefacts import CrispTree


class Offer(NamedTuple):
    """A node of a tree, as its place among all trees, and which of a goal's cells it sees."""

    tree: int
    node: int
    seen: Bool[np.ndarray, "cell"]


def restrict(surface: SurfaceCells, cells: Int[np.ndarray, "cell 3"]) -> SurfaceCells:
    """Return a surface of which only these cells are looked at."""
    numbers = np.full(surface.free.shape, -1, np.int32)
    numbers[tuple(cells.T)] = np.arange(len(cells))
    return replace(surface, cells=cells.astype(np.int32), numbers=numbers)


def find_seen(
    surface: SurfaceCells, camera: np.ndarray, view: np.ndarray, field_of_view_deg: float
) -> Bool[np.ndarray, "cell"]:
    """Return which of a surface's cells a camera sees."""
    first_nodes = np.full(len(surface.cells), -1)
    look(surface, camera[None], view[None], field_of_view_deg, "own ray", first_nodes)
    return first_nodes >= 0


def collect_offers(
    surface: SurfaceCells,
    trees: tuple[CrispTree, ...],
    chosen: Bool[np.ndarray, "goal_cell"],
) -> list[Offer]:
    """Return the first nodes that see a goal's cells, and what else of them each sees.

    Parameters
    ----------
    surface : of the goal's cells alone.
    chosen : which of all goals' cells are the goal's.
    """
    offers = []
    for number, tree in enumerate(trees):
        nodes = np.unique(tree.seeing[chosen])
        for node in nodes[nodes >= 0].tolist():
            offers.append(make_offer(surface, trees, number, node))
    return offers


def make_offer(
    surface: SurfaceCells, trees: tuple[CrispTree, ...], number: int, node: int
) -> Offer:
    """Return what a node sees of the goal's cells."""
    tree = trees[number]
    angle = tree.placed.setup.field_of_view_deg
    camera, view = tree.cameras_patient_mm[node], tree.views[node]
    return Offer(number, node, find_seen(surface, camera, view, angle))


def find_next(surface: SurfaceCells, trees: tuple[CrispTree, ...], offer: Offer) -> Offer | None:
    """Return the next node of the same tree that sees any of the cells which another one saw."""
    tree, later = trees[offer.tree], offer.node + 1
    wanted = restrict(surface, surface.cells[offer.seen])
    first_nodes = np.full(len(wanted.cells), -1)
    look(
        wanted, tree.cameras_patient_mm[later:], tree.views[later:],
        tree.placed.setup.field_of_view_deg, "own ray", first_nodes, later,
    )  # fmt: skip
    seeing = first_nodes[first_nodes >= 0]
    if not len(seeing):
        return None
    return make_offer(surface, trees, offer.tree, int(seeing.min()))
