"""Small systems against NumPy."""

import numpy as np
import pytest

from nodes.kernels.crisp_linear import factorise, solve_factorised


@pytest.mark.parametrize("size", [1, 6, 12, 18, 24])
def test_solution_is_numpys(size):
    chance = np.random.default_rng(size)
    # Rows of very different size, and a zero on the diagonal: pivots have to be sought.
    matrix = chance.normal(size=(size, size)) * 10 ** chance.uniform(-4, 4, (size, 1))
    matrix[0, 0] = 0 if size > 1 else 2
    right = chance.normal(size=size)
    triangles, order, found = matrix.copy(), np.empty(size, np.int64), right.copy()
    assert factorise(triangles, order)
    solve_factorised(triangles, order, found)
    assert found == pytest.approx(np.linalg.solve(matrix, right), rel=1e-8)


@pytest.mark.parametrize(
    "bad", [np.zeros((3, 3)), np.full((3, 3), np.nan), np.full((3, 3), np.inf)]
)
def test_singular_matrix_is_told(bad):
    assert not factorise(bad.copy(), np.empty(3, np.int64))
