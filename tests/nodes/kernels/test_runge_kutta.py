"""The table against the conditions of its order, one for each rooted tree, with fractions."""

from fractions import Fraction
from itertools import combinations_with_replacement

import pytest

from nodes.kernels.runge_kutta import FIRST, STAGE, STAGES, WEIGHT

ROWS = [
    {int(STAGE[k]): Fraction(float(WEIGHT[k])) for k in range(FIRST[i], FIRST[i + 1])}
    for i in range(STAGES + 1)
]


def trees(order):
    """Return all rooted trees of an order, as sorted tuples of their branches."""
    if order == 1:
        return [()]
    return sorted({tuple(sorted(branches)) for branches in forests(order - 1, order - 1)})


def forests(nodes, largest):
    if nodes == 0:
        return [()]
    found = []
    for size in range(1, min(nodes, largest) + 1):
        for number in range(1, nodes // size + 1):
            for some in combinations_with_replacement(trees(size), number):
                found += [some + rest for rest in forests(nodes - size * number, size - 1)]
    return found


def order_of(tree):
    return 1 + sum(map(order_of, tree))


def density(tree):
    result = Fraction(order_of(tree))
    for branch in tree:
        result *= density(branch)
    return result


def at_stages(tree):
    """Return the elementary weight of a tree at each stage."""
    values = [Fraction(1)] * STAGES
    for branch in tree:
        inner = at_stages(branch)
        values = [
            value * sum((weight * inner[stage] for stage, weight in ROWS[i].items()), Fraction(0))
            for i, value in enumerate(values)
        ]
    return values


@pytest.mark.parametrize("order", range(1, 9))
def test_every_condition_of_order_eight_holds(order):
    known = {1: 1, 2: 1, 3: 2, 4: 4, 5: 9, 6: 20, 7: 48, 8: 115}
    found = trees(order)
    assert len(found) == known[order]
    for tree in found:
        values = at_stages(tree)
        weight = sum((share * values[stage] for stage, share in ROWS[STAGES].items()), Fraction(0))
        # Sixteen digits of weights up to 43, of which several are multiplied.
        assert abs(weight - 1 / density(tree)) < 1e-13


def test_stages_use_earlier_ones_alone():
    assert all(stage < i for i in range(STAGES) for stage in ROWS[i])
