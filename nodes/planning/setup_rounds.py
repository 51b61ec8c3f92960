"""Candidates grown in rounds: the best half goes on, and grows twice as far [Karnin2013]."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool

from nodes.geometry.coverage import choose_best_sets
from nodes.planning.artefacts import Goals
from nodes.planning.parameters import SearchCrispSetupsParameters
from nodes.planning.setup_candidates import Candidate, Place
from nodes.planning.setup_scores import find_columns, see
from nodes.planning.tree_growth import grow_tree


class Grown(NamedTuple):
    """What growing a candidate has shown so far.

    shares : of the surface, seen at the end of each of its rounds.
    seen : (cell,) at the end of its last round.
    goals : how many goals it saw then, a region in part counting as that part.
    nodes : of its last tree.
    """

    candidate: Candidate
    shares: tuple[float, ...]
    seen: Bool[np.ndarray, " cell"]
    goals: float
    nodes: int


def grow_in_rounds(
    candidates: list[Candidate], place: Place, parameters: SearchCrispSetupsParameters
) -> list[Grown]:
    """Return all candidates with what they saw, the chosen ones first.

    Of each round those go on that together see most; the last round's trees have `node_limit`
    nodes, those of each before it half as many.
    """
    columns = find_columns(place.surface, place.goals, parameters.for_goals)
    going = [Grown(one, (), np.zeros(len(place.surface.cells), bool), 0.0, 0) for one in candidates]
    out: list[Grown] = []
    for round_number in range(parameters.rounds):
        nodes = max(1, parameters.node_limit >> (parameters.rounds - 1 - round_number))
        chosen_nodes = parameters.model_copy(update={"node_limit": nodes})
        going = [_grow(one, place, chosen_nodes) for one in going]
        going.sort(key=lambda one: -one.shares[-1])
        last = round_number == parameters.rounds - 1
        keep = parameters.setups if last else max(parameters.setups, -(-len(going) // 2))
        best = choose_best_sets(np.array([one.seen[columns] for one in going]), keep)
        rest = [one for number, one in enumerate(going) if number not in best]
        going, out = [going[number] for number in best], rest + out
    return going + out


def _grow(grown: Grown, place: Place, parameters: SearchCrispSetupsParameters) -> Grown:
    placed = grown.candidate.placed
    tree = grow_tree(placed, place.cavity, place.wall, np.zeros((0, 3), int), parameters)
    view = placed.setup.field_of_view_deg
    seen = see(place.surface, tree.cameras_patient_mm, tree.views, view)
    return grown._replace(
        shares=(*grown.shares, float(seen.mean())),
        seen=seen,
        goals=count_goals(place, seen, place.goals),
        nodes=len(tree.parents),
    )


def count_goals(place: Place, seen: Bool[np.ndarray, " cell"], goals: Goals) -> float:
    """Return how many goals are seen, of regions the share."""
    own = seen[place.surface.numbers[tuple(goals.cells.T)]]
    cells = np.bincount(goals.goals, minlength=len(goals.names))
    return float((np.bincount(goals.goals, own, minlength=len(goals.names)) / cells).sum())
