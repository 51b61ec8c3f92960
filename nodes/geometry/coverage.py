"""What several looks at one surface see together, and when."""

from collections.abc import Sequence
from itertools import combinations
from math import comb

import numpy as np
from jaxtyping import Bool, Float, Int

MOST_CHOICES = 20_000  # so many sets of k are all tried; of more the best is sought step by step


def times_first_seen(
    first_nodes: Int[np.ndarray, "cell"], seconds: Float[np.ndarray, "node"]
) -> Float[np.ndarray, "cell"]:
    """Return when each cell was seen first; nan where it never was.

    Parameters
    ----------
    first_nodes : the first node that sees each cell, or -1.
    seconds : when each node was there; later nodes are not earlier.
    """
    seen = first_nodes >= 0
    return np.where(seen, seconds[np.where(seen, first_nodes, 0)], np.nan)


def share_over_time(
    first_nodes: Int[np.ndarray, "cell"], seconds: Float[np.ndarray, "node"]
) -> tuple[Float[np.ndarray, "change"], Float[np.ndarray, "change"]]:
    """Return the times at which the share of seen cells grows, and the share from then on.

    [Kuntz2017] Fig. 6, the dashed lines; divided by the last share, its solid lines.
    """
    times = times_first_seen(first_nodes, seconds)
    changes, counts = np.unique(times[first_nodes >= 0], return_counts=True)
    return changes, np.cumsum(counts) / len(first_nodes)


def choose_best_sets(seen: Bool[np.ndarray, "set cell"], count: int) -> tuple[int, ...]:
    """Return which sets together see most cells, the one that sees most by itself first.

    All choices of `count` sets are compared while they are few; else the set that adds most is
    taken, again and again, which sees at least 1 - 1/e of the most [Nemhauser1978]. Of equal
    choices the one of earlier sets is taken.

    Parameters
    ----------
    seen : whether each set sees each cell.
    count : of the sets to choose, at least 1; all of them if there are fewer.
    """
    count = min(count, len(seen))
    if comb(len(seen), count) > MOST_CHOICES:
        return _choose_greedily(seen, range(len(seen)), count)
    packed = np.packbits(seen, axis=1)
    together = {
        choice: int(np.bitwise_count(np.bitwise_or.reduce(packed[list(choice)])).sum())
        for choice in combinations(range(len(seen)), count)
    }
    best = max(together, key=lambda choice: together[choice])  # the first of equal ones
    return _choose_greedily(seen, best, count)


def _choose_greedily(
    seen: Bool[np.ndarray, "set cell"], choices: Sequence[int], count: int
) -> tuple[int, ...]:
    """Return `count` of the choices, each the one that adds most to those before it."""
    left, missing, chosen = list(choices), np.ones(seen.shape[1], bool), []
    for _ in range(count):
        gains = [np.count_nonzero(seen[one] & missing) for one in left]
        chosen.append(left.pop(int(np.argmax(gains))))
        missing &= ~seen[chosen[-1]]
    return tuple(chosen)
