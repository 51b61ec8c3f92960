"""Points of the backbone between nodes: on each step the polynomial of degree 9 through p and its
first four derivatives by arc length at both ends."""

from fractions import Fraction
from math import comb

from numba import njit

from nodes.kernels.ctr_lanes import LANES, count_up, load_rows, store_points, store_rows
from nodes.kernels.ctr_nodes import CURVE, HIGH_BEND, LOW_BEND, MOTION, ROWS, TURNING
from nodes.kernels.ctr_options import INNER, INSIDE
from nodes.kernels.ctr_rotations import rotate
from nodes.kernels.ctr_tuples import take


def _inverse(rows: list[list[int]]) -> tuple[tuple[float, ...], ...]:
    """Invert a small matrix of whole numbers exactly."""
    size = len(rows)
    work = [
        [Fraction(x) for x in row] + [Fraction(int(i == k)) for k in range(size)]
        for i, row in enumerate(rows)
    ]
    for i in range(size):
        pivot = next(k for k in range(i, size) if work[k][i])
        work[i], work[pivot] = work[pivot], work[i]
        work[i] = [x / work[i][i] for x in work[i]]
        for k in range(size):
            if k != i:
                work[k] = [x - work[k][i] * y for x, y in zip(work[k], work[i], strict=True)]
    return tuple(tuple(float(x) for x in row[size:]) for row in work)


# Coefficients 5 to 9 from what value and derivatives / k! lack at the upper end.
CLOSE = _inverse([[comb(5 + j, k) for j in range(5)] for k in range(5)])


@njit(**INSIDE)
def _derivatives(h, bend):
    """Return h^2 p''/2, h^3 p'''/6 and h^4 p''''/24 in the body's frame, where h p' = h e3.

    With p' = R e3 and R' = R [u], p^(k+1) = R (u x w_k + w_k') for p^(k) = R w_k.
    """
    x, y, z, x1, y1, x2, y2 = bend
    bent = x * x + y * y
    two = h * h * (1 / 2)
    three = two * h * (1 / 3)
    four = three * h * (1 / 4)
    rest_x = 2 * x1 * z + y2 - y * bent - z * z * y
    rest_y = 2 * y1 * z - x2 + x * bent + z * z * x
    return (
        (two * y, -two * x),
        (three * (x * z + y1), three * (y * z - x1), -three * bent),
        (four * rest_x, four * rest_y, -3 * four * (x * x1 + y * y1)),
    )


@njit(**INNER)
def fit_curves(lanes, block):
    """Write the coefficients of the polynomials by t in [0, 1] through eight steps, in the frames
    at their lower ends: those of degree 2 to 9 across, of degree 3 to 9 along the tangent."""
    bend = (0.0,) * 7
    (h,) = load_rows((0.0,), lanes, block)
    gap = load_rows((0.0,) * 3, lanes, block + MOTION + 9)
    turning = load_rows((0.0,) * 9, lanes, block + TURNING)
    two, three, four = _derivatives(h, load_rows(bend, lanes, block + LOW_BEND))
    flat, end3, end4 = _derivatives(h, load_rows(bend, lanes, block + HIGH_BEND))
    end1 = (h * turning[2], h * turning[5], h * turning[8])
    end2 = (
        turning[0] * flat[0] + turning[1] * flat[1],
        turning[3] * flat[0] + turning[4] * flat[1],
        turning[6] * flat[0] + turning[7] * flat[1],
    )
    end3, end4 = rotate(turning, end3), rotate(turning, end4)
    for i in range(2):
        known = (two[i], three[i], four[i])
        high = _close(
            gap[i] - two[i], end1[i] - 2 * two[i], end2[i] - two[i], end3[i], end4[i], known[1:]
        )
        store_rows(known + high, lanes, block + CURVE + 8 * i)
    high = _close(gap[2] - h, end1[2] - h, end2[2], end3[2], end4[2], (three[2], four[2]))
    store_rows((three[2], four[2], *high), lanes, block + CURVE + 16)


@njit(**INSIDE)
def _close(lack0, lack1, lack2, end3, end4, known):
    """Return coefficients 5 to 9 from what the others, but 3 and 4, leave to the upper end."""
    three, four = known
    a = lack0 - three - four
    b = lack1 - 3 * three - 4 * four
    c = lack2 - 3 * three - 6 * four
    d = end3 - three - 4 * four
    e = end4 - four
    return (
        _sum5(CLOSE[0], a, b, c, d, e),
        _sum5(CLOSE[1], a, b, c, d, e),
        _sum5(CLOSE[2], a, b, c, d, e),
        _sum5(CLOSE[3], a, b, c, d, e),
        _sum5(CLOSE[4], a, b, c, d, e),
    )


@njit(**INSIDE)
def _sum5(row, a, b, c, d, e):
    return row[0] * a + row[1] * b + row[2] * c + row[3] * d + row[4] * e


@njit(**INNER)
def sample_points(nodes, steps, row, places, points):
    """Write points at even distances from the entry to the tip, and where those are.

    Parameters
    ----------
    nodes, steps : with frames placed; `nodes.samples` is written.
    row : which configuration.
    places : (k, n) written, mm from the entry.
    points : (k, n, 3) written, mm.
    """
    count, length = places.shape[1], nodes.place[0] if steps > 0 else 0.0
    spacing = length / max(count - 1, 1)
    for i in range(count):
        places[row, i] = spacing * i
    sample = 0
    for k in range(steps - 1, -1, -1):
        block, lane = k // LANES * ROWS, k % LANES
        if lane == LANES - 1 or k == steps - 1:
            fit_curves(nodes.lanes, block)
        stop = count if k == 0 else min(int(nodes.place[k] / spacing) + 1, count)
        for first in range(sample, stop, LANES):
            _evaluate(nodes, k, block, lane, first, spacing)
        sample = max(sample, stop)
    if steps == 0:  # drawn in completely
        for i in range(count):
            for axis in range(3):
                nodes.samples[i, axis] = nodes.frame[0, 9 + axis]
    for i in range(count):
        for axis in range(3):
            points[row, i, axis] = nodes.samples[i, axis]


@njit(**INSIDE)
def _evaluate(nodes, k, block, lane, first, spacing):
    """Write the eight points that begin with a sample; those beyond the step, the next one will."""
    lanes, at = nodes.lanes, block + CURVE
    h = lanes[block, lane]
    t = (count_up(float(first)) * spacing - nodes.place[k + 1]) * (1.0 / h)
    w = t * t
    x = w * _value(lanes, at, lane, t, w)
    y = w * _value(lanes, at + 8, lane, t, w)
    z = h * t + w * t * _value_along(lanes, at + 16, lane, t, w)
    frame = take((0.0,) * 12, nodes.frame, k + 1, 0)
    store_points(
        frame[0] * x + frame[1] * y + frame[2] * z + frame[9],
        frame[3] * x + frame[4] * y + frame[5] * z + frame[10],
        frame[6] * x + frame[7] * y + frame[8] * z + frame[11],
        nodes.samples,
        first,
    )


@njit(**INSIDE)
def _value(c, at, lane, t, w):
    """Return sum c_k t^k for eight coefficients in a column."""
    low = (c[at, lane] + t * c[at + 1, lane]) + w * (c[at + 2, lane] + t * c[at + 3, lane])
    high = (c[at + 4, lane] + t * c[at + 5, lane]) + w * (c[at + 6, lane] + t * c[at + 7, lane])
    return low + w * w * high


@njit(**INSIDE)
def _value_along(c, at, lane, t, w):
    """Return sum c_k t^k for seven coefficients in a column."""
    low = (c[at, lane] + t * c[at + 1, lane]) + w * (c[at + 2, lane] + t * c[at + 3, lane])
    return low + w * w * (c[at + 4, lane] + t * c[at + 5, lane] + w * c[at + 6, lane])
