"""What sets see together against brute force, and shares over time against counting."""

from itertools import combinations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nodes.geometry import coverage
from nodes.geometry.coverage import choose_best_sets, share_over_time, times_first_seen

SEEN = arrays(bool, st.tuples(st.integers(1, 6), st.integers(1, 20)))


def together(seen, chosen):
    return int(np.any([seen[one] for one in chosen], axis=0).sum())


def test_times_are_those_of_the_first_nodes_and_nan_where_nothing_was_seen():
    times = times_first_seen(np.array([2, -1, 0]), np.array([0.5, 1.0, 4.0]))
    np.testing.assert_array_equal(times, [4.0, np.nan, 0.5])


@given(
    st.lists(st.integers(-1, 5), min_size=1), st.lists(st.integers(0, 9), min_size=6, max_size=6)
)
def test_share_over_time_counts_what_was_seen_by_then(first_nodes, seconds):
    first, at = np.array(first_nodes), np.sort(np.array(seconds, float))
    times, shares = share_over_time(first, at)
    assert (np.diff(times) > 0).all() and (np.diff(shares, prepend=0) > 0).all()
    for time in range(10):
        seen = sum(1 for node in first if node >= 0 and at[node] <= time)
        last = np.searchsorted(times, time, side="right")
        assert (shares[last - 1] if last else 0.0) == seen / len(first)


@given(SEEN, st.integers(1, 7))
def test_no_other_choice_sees_more(seen, count):
    chosen = choose_best_sets(seen, count)
    size = min(count, len(seen))
    assert len(set(chosen)) == len(chosen) == size
    most = max(together(seen, one) for one in combinations(range(len(seen)), size))
    assert together(seen, chosen) == most
    assert seen[chosen[0]].sum() == max(seen[one].sum() for one in chosen)


@given(SEEN, st.integers(1, 6))
def test_step_by_step_choices_see_their_share_of_the_most(seen, count):
    limit, coverage.MOST_CHOICES = coverage.MOST_CHOICES, 0
    try:
        chosen = choose_best_sets(seen, count)
    finally:
        coverage.MOST_CHOICES = limit
    size = min(count, len(seen))
    most = max(together(seen, one) for one in combinations(range(len(seen)), size))
    assert len(set(chosen)) == size and together(seen, chosen) >= (1 - np.exp(-1)) * most


def test_the_best_pair_need_not_hold_the_best_one():
    seen = np.zeros((3, 10), bool)
    seen[0, 2:8], seen[1, :5], seen[2, 5:] = True, True, True
    assert choose_best_sets(seen, 1) == (0,)
    assert choose_best_sets(seen, 2) == (1, 2)
    assert choose_best_sets(seen[:0], 2) == ()
