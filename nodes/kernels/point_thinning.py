"""Points thinned to a least distance: dart throwing with a hashed grid."""

import numpy as np
from numba import njit

PRIMES = (73856093, 19349663, 83492791)  # spread cells over the table


@njit(cache=True, nogil=True, error_model="numpy")
def thin_points(points, apart):
    """Return which points are kept, going through them in order: each that has no kept one nearer
    than `apart`.

    Every point is nearer than `apart` to a kept one in the end, or kept itself. Cells of that size
    are chained in a table by a hash, so memory follows the points and not their extent.

    Parameters
    ----------
    points : (n, 3) float64.
    apart : least distance.
    """
    count = len(points)
    size = 1
    while size < 2 * count:
        size *= 2
    last, before = np.full(size, -1, np.int64), np.full(count, -1, np.int64)
    kept = np.zeros(count, np.bool_)
    for n in range(count):
        i = int(np.floor(points[n, 0] / apart))
        j = int(np.floor(points[n, 1] / apart))
        k = int(np.floor(points[n, 2] / apart))
        if _is_alone(points, n, i, j, k, apart, last, before):
            kept[n] = True
            place = _place(i, j, k, size)
            before[n], last[place] = last[place], n
    return kept


@njit(cache=True, nogil=True, error_model="numpy")
def _is_alone(points, n, i, j, k, apart, last, before):
    for a in range(i - 1, i + 2):
        for b in range(j - 1, j + 2):
            for c in range(k - 1, k + 2):
                other = last[_place(a, b, c, len(last))]
                while other >= 0:
                    squared = 0.0
                    for axis in range(3):
                        squared += (points[n, axis] - points[other, axis]) ** 2
                    if squared < apart * apart:
                        return False
                    other = before[other]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _place(i, j, k, size):
    return ((i * PRIMES[0]) ^ (j * PRIMES[1]) ^ (k * PRIMES[2])) & (size - 1)
