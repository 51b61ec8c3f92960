"""Ways made shorter and smoother by short cuts that are valid."""

import numpy as np
from jaxtyping import Float, Int

from nodes.planning.plan_edges import Ground, end_alike, find_good, pick_ends, walk_edges
from nodes.planning.plan_paths import Path, places_along, way_lengths

LEAST_GAIN = 1e-3  # share of what it replaces, by which a short cut is shorter
Pairs = Int[np.ndarray, "pair 2"]


def shorten_path(ground: Ground, path: Path, rng: np.random.Generator) -> Path:
    """Return a way made of short cuts between places spread along it, and then at random."""
    parameters = ground.parameters
    path = take_shortcuts(ground, path, _pair_waypoints(path, parameters.waypoints, ground))
    for _ in range(parameters.rounds):
        along = places_along(path, parameters.lever_mm)
        drawn = np.searchsorted(along, rng.uniform(0, along[-1], (parameters.tries, 2)))
        path = take_shortcuts(ground, path, np.sort(drawn, axis=1))
    return path


def smooth_path(ground: Ground, path: Path) -> Path:
    """Return a way whose corners are cut off, first widely, then more and more closely."""
    along = places_along(path, ground.parameters.lever_mm)
    reach = along[-1] / 2
    for _ in range(ground.parameters.rounds):
        along = places_along(path, ground.parameters.lever_mm)
        corners = path.corners[1:-1]
        around = np.stack([along[corners] - reach, along[corners] + reach], axis=1)
        path = take_shortcuts(ground, path, np.searchsorted(along[:-1], around))
        reach /= 2
    return path


def _pair_waypoints(path: Path, count: int, ground: Ground) -> Pairs:
    along = places_along(path, ground.parameters.lever_mm)
    places = np.unique(np.searchsorted(along, np.linspace(0, along[-1], count)))
    pairs = np.stack(np.triu_indices(len(places), 1), axis=1)
    return places[pairs]


def take_shortcuts(ground: Ground, path: Path, pairs: Pairs) -> Path:
    """Return a way with those geodesics between pairs of its places that are valid, and together
    save most.

    A geodesic must arrive at the equilibrium that is known at its end: it could lead to another
    shape of the robot.
    """
    lever = ground.parameters.lever_mm
    along = places_along(path, lever)
    pairs = np.unique(pairs[pairs[:, 1] > pairs[:, 0] + 1], axis=0)
    ends = pick_ends(path, *pairs.T)
    gains = along[pairs[:, 1]] - along[pairs[:, 0]] - way_lengths(*ends[:4], lever)
    is_worth = gains > LEAST_GAIN * (along[pairs[:, 1]] - along[pairs[:, 0]])
    if not is_worth.any():
        return path
    pairs, gains = pairs[is_worth], gains[is_worth]
    ends = pick_ends(path, *pairs.T)
    walked = walk_edges(ground, ends)
    is_valid = find_good(ground, walked).all(axis=1)
    is_valid &= end_alike(ground, ends, walked)
    valid = np.flatnonzero(is_valid)
    chosen = valid[choose_apart(pairs[valid], gains[valid])]
    for edge in chosen[::-1].tolist():  # the last first, so that places before stay as they are
        path = path.replaced(*pairs[edge].tolist(), walked.cut(edge))
    return path


def choose_apart(pairs: Pairs, gains: Float[np.ndarray, "pair"]) -> Int[np.ndarray, "chosen"]:
    """Return the pairs, in order, that do not overlap and whose gains add up to most."""
    order = np.lexsort((pairs[:, 0], pairs[:, 1]))
    firsts, lasts = pairs[order].T
    before = np.searchsorted(lasts, firsts, side="right")  # how many end where each begins
    best = np.zeros(len(order) + 1)
    for place, gain in enumerate(gains[order]):
        best[place + 1] = max(best[place], best[before[place]] + gain)
    chosen, place = [], len(order)
    while place > 0:
        if best[place] > best[place - 1]:
            chosen.append(order[place - 1])
            place = before[place - 1]
        else:
            place -= 1
    return np.array(chosen[::-1], int)
