"""Tubes that cannot be made, or do not lie in each other, are refused with their numbers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodes.errors import BadInput
from nodes.mechanics.check_tubes import check_diameters, check_lengths, check_nest, check_strain

sizes = st.floats(0.01, 10)


@pytest.mark.parametrize(
    ("inner", "outer", "told"),
    [(1.0, 0.9, "0.9"), (1.0, 1.0, "smaller"), (-0.1, 1.0, "-0.1"), (0.0, 0.0, "outer_diameter")],
)
def test_a_tube_without_wall_is_refused(inner, outer, told):
    with pytest.raises(BadInput, match=told):
        check_diameters(inner, outer)


def test_a_wire_has_no_inside():
    check_diameters(0.0, 0.3)


@pytest.mark.parametrize(("straight", "curved"), [(-1.0, 5.0), (5.0, -1.0), (0.0, 0.0)])
def test_lengths_below_or_all_zero_are_refused(straight, curved):
    with pytest.raises(BadInput, match="_length_mm"):
        check_lengths(straight, curved)
    check_lengths(0.0, 5.0)
    check_lengths(5.0, 0.0)


@given(sizes, st.floats(0.001, 0.2), st.floats(0, 1), st.floats(0, 1))
def test_strain_is_the_largest_eigenvalue_of_the_strain_at_the_surface(outer, limit, bend, twist):
    """By numpy, of the plane strain tensor with the axial strain and half the shear."""
    axial, shear = bend * outer / 2, twist * outer / 2
    largest = np.linalg.eigvalsh([[axial, shear / 2], [shear / 2, 0.0]]).max()
    if abs(largest - limit) < 1e-9:
        return
    if largest < limit:
        check_strain("curvature", bend, twist, outer, limit)
    else:
        with pytest.raises(BadInput, match="curvature"):
            check_strain("curvature", bend, twist, outer, limit)


@given(st.lists(st.tuples(sizes, sizes), min_size=1, max_size=4))
def test_a_nest_is_refused_exactly_where_two_neighbours_do_not_fit(walls):
    inner, outer = zip(*[(min(wall), max(wall)) for wall in walls], strict=True)
    fits = all(outer[i] <= inner[i + 1] for i in range(len(walls) - 1))
    lengths = tuple(10.0 - i for i in range(len(walls)))
    if fits:
        check_nest(inner, outer, lengths)
    else:
        with pytest.raises(BadInput, match="fits into the next"):
            check_nest(inner, outer, lengths)


def test_tubes_that_touch_fit():
    check_nest((0.5, 1.0), (1.0, 1.5), (10.0, 10.0))


def test_an_inner_tube_is_not_shorter():
    with pytest.raises(BadInput, match=r"tubes\[0\] is 9 mm long.*\n?.*10 mm"):
        check_nest((0.5, 1.0), (1.0, 1.5), (9.0, 10.0))


@pytest.mark.parametrize("count", [0, 5])
def test_no_and_five_tubes_are_refused(count):
    inner = tuple(1.0 + 2 * i for i in range(count))
    with pytest.raises(BadInput, match=f"{count} tubes"):
        check_nest(inner, tuple(x + 1 for x in inner), (10.0,) * count)
