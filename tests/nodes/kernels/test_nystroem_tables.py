"""Order conditions of Runge-Kutta-Nystroem methods in fractions, over all trees."""

from fractions import Fraction
from math import prod

import pytest

from nodes.kernels.nystroem_tables import EXACT_4, EXACT_8, ORDER_8


def trees(order):
    """All trees of an order: how often y' enters, and the trees below; f(y) has no more."""
    if order == 1:
        return [(0, ())]
    return [
        (straight, below)
        for straight in range(order)
        for below in forests(order - 1 - straight, order)
    ]


def forests(size, largest):
    """Multisets of trees, each counting its order and one."""
    if size == 0:
        return [()]
    return [
        (tree, *rest)
        for first in range(min(size - 1, largest), 0, -1)
        for tree in trees(first)
        for rest in forests(size - first - 1, first)
    ]


def order_of(tree):
    return 1 + tree[0] + sum(order_of(below) + 1 for below in tree[1])


def stage_weights(tree, method):
    """What the tree's derivative is multiplied by at each stage."""
    inner = [stage_weights(below, method) for below in tree[1]]
    return [
        c ** tree[0] * prod(sum(a * w for a, w in zip(row, one, strict=False)) for one in inner)
        for c, row in zip(method.nodes, method.stages, strict=True)
    ]


def exact_weight(tree):
    """The same for the exact solution at the end of the step."""
    parts = [(exact_weight(below), order_of(below)) for below in tree[1]]
    return prod(weight / (n * (n + 1)) for weight, n in parts) * Fraction(1)


@pytest.mark.parametrize(("method", "order"), [(EXACT_4, 4), (EXACT_8, 8)])
def test_methods_fulfil_all_conditions_of_their_order_and_not_of_the_next(method, order):
    def misses(n):
        return [
            tree
            for tree in trees(n)
            if sum(d * w for d, w in zip(method.rates, stage_weights(tree, method), strict=True))
            != exact_weight(tree) / n
        ]

    assert not any(misses(n) for n in range(1, order + 1))
    assert misses(order + 1)
    # With this all conditions for values follow from those for rates [Hairer1993] II.14.
    weights = zip(method.values, method.rates, method.nodes, strict=True)
    assert all(b == d * (1 - c) for b, d, c in weights)
    for c, row in zip(method.nodes, method.stages, strict=True):
        assert sum(row) == c * c / 2


def test_there_are_as_many_trees_as_the_literature_counts():
    # [Hairer1993] II.14: special Nystroem trees of orders 1 to 8
    assert [len(trees(n)) for n in range(1, 9)] == [1, 1, 2, 3, 6, 10, 20, 36]


def test_floats_are_the_fractions():
    assert ORDER_8.stages[7][1] == -17731450 / 1833729
