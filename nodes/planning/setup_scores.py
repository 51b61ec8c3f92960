"""What unbent starts see, quickly: the first choice among many set-ups."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from nodes.geometry.lines_of_sight import SurfaceCells, look
from nodes.planning.artefacts import Goals
from nodes.planning.setup_starts import PARTS, Entries, Starts

OWN_RAY = "own ray"
ENOUGH_CELLS = 16_384  # of a surface, evenly spread over it, to order set-ups by what they see
GOAL_WEIGHT = 64  # columns that each goal has, however many cells it is


class Pairs(NamedTuple):
    """Pairs of entries, for a tool and a snare, that have free unbent starts.

    best : (pair,) the start of each that sees most by itself.
    seen : (pair, cell) what all starts of a pair see together.
    """

    best: Int[np.ndarray, " pair"]
    seen: Bool[np.ndarray, "pair cell"]


def thin_surface(
    surface: SurfaceCells, kept: Int[np.ndarray, "cell 3"], most: int = ENOUGH_CELLS
) -> SurfaceCells:
    """Return a surface of which only every n-th cell is looked at, and those to be kept."""
    step = -(-len(surface.cells) // most)
    chosen = np.zeros(len(surface.cells), bool)
    chosen[::step] = True
    chosen[surface.numbers[tuple(kept.T)]] = True
    cells = surface.cells[chosen]
    numbers = np.full_like(surface.numbers, -1)
    numbers[tuple(cells.T)] = np.arange(len(cells))
    return replace(surface, cells=cells, numbers=numbers)


def find_columns(surface: SurfaceCells, goals: Goals, for_goals: bool) -> Int[np.ndarray, " n"]:
    """Return which cells of a surface count when set-ups are compared: all, or those of goals.

    Each goal counts alike: large regions are thinned, small ones are counted repeatedly.
    """
    if not for_goals or not goals.names:
        return np.arange(len(surface.cells))
    columns = []
    for goal in range(len(goals.names)):
        own = surface.numbers[tuple(goals.cells[goals.goals == goal].T)]
        columns.append(own[np.linspace(0, len(own) - 1, GOAL_WEIGHT).astype(int)])
    return np.concatenate(columns).astype(int)


def score_pairs(
    entries: Entries,
    starts: Starts,
    grasp_mm: float,
    field_of_view_deg: float,
    surface: SurfaceCells,
) -> Pairs:
    """Look from all starts of each pair.

    Parameters
    ----------
    starts : free ones, those of a pair together.
    grasp_mm : of the tool beyond the joint.
    """
    keys = starts.tools * len(entries.points) + starts.snares
    bounds = np.append(np.flatnonzero(np.diff(keys, prepend=-1)), len(keys))
    cameras, views = cameras_of(entries, starts, grasp_mm)
    seen = np.zeros((len(bounds) - 1, len(surface.cells)), bool)
    best = np.zeros(len(seen), int)

    def score(pairs: np.ndarray) -> None:
        for pair in pairs:
            counts = []
            for start in range(bounds[pair], bounds[pair + 1]):
                one = slice(start, start + 1)
                own = see(surface, cameras[one], views[one], field_of_view_deg)
                counts.append(np.count_nonzero(own))
                seen[pair] |= own
            best[pair] = bounds[pair] + int(np.argmax(counts))

    with ThreadPoolExecutor(PARTS) as pool:
        list(pool.map(score, np.array_split(np.arange(len(seen)), PARTS)))
    return Pairs(best, seen)


def see(
    surface: SurfaceCells,
    cameras_patient_mm: Float[np.ndarray, "node 3"],
    views: Float[np.ndarray, "node 3"],
    field_of_view_deg: float,
) -> Bool[np.ndarray, " cell"]:
    """Return which cells any of the cameras sees."""
    first = np.full(len(surface.cells), -1)
    look(surface, cameras_patient_mm, views, field_of_view_deg, OWN_RAY, first)
    return first >= 0


def cameras_of(
    entries: Entries, starts: Starts, grasp_mm: float
) -> tuple[Float[np.ndarray, "start 3"], Float[np.ndarray, "start 3"]]:
    """Return where the cameras are, and along what they look."""
    lengths = starts.feet_mm + grasp_mm
    return entries.points[starts.tools] + lengths[:, None] * starts.tangents, starts.tangents
