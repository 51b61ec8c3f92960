"""Small dense linear systems: elimination with the largest pivot of each column."""

import numpy as np
from numba import njit

from nodes.kernels.crisp_options import OUTER


@njit(fastmath={"contract"}, **OUTER)
def factorise(matrix, order):
    """Split a square matrix in place into its triangles; return whether it is regular.

    order : (n,) int64, written: which row was swapped to each place.
    """
    n = len(order)
    for k in range(n):
        pivot, largest = k, abs(matrix[k, k])
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > largest:
                pivot, largest = i, abs(matrix[i, k])
        order[k] = pivot
        if not (0.0 < largest < np.inf):
            return False
        if pivot != k:
            for j in range(n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
        inverse = 1 / matrix[k, k]
        for i in range(k + 1, n):
            share = matrix[i, k] * inverse
            matrix[i, k] = share
            if share != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= share * matrix[k, j]
    return True


@njit(fastmath={"contract"}, **OUTER)
def solve_factorised(triangles, order, right):
    """Solve for one right-hand side in place."""
    n = len(order)
    for k in range(n):
        pivot = order[k]
        right[k], right[pivot] = right[pivot], right[k]
    for i in range(1, n):
        total = right[i]
        for j in range(i):
            total -= triangles[i, j] * right[j]
        right[i] = total
    for i in range(n - 1, -1, -1):
        total = right[i]
        for j in range(i + 1, n):
            total -= triangles[i, j] * right[j]
        right[i] = total / triangles[i, i]
