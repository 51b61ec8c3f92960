"""Points of the backbone between nodes: on each step the polynomial of degree 9 through p and its
first four derivatives by arc length at both ends."""

from fractions import Fraction
from math import comb

from numba import njit
from numba.cpython.unsafe.tuple import tuple_setitem

from nodes.kernels.ctr_options import INNER
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


@njit(**INNER)
def _derivatives(h, bend):
    """Return h p', h^2 p''/2, h^3 p'''/6 and h^4 p''''/24 in the body's frame.

    With p' = R e3 and R' = R [u], p^(k+1) = R (u x w_k + w_k') for p^(k) = R w_k.
    """
    x, y, z, x1, y1, x2, y2 = bend
    bent = x * x + y * y
    two = h * h / 2
    three = two * h / 3
    four = three * h / 4
    first = (x * z + y1, y * z - x1, -bent)
    lean = 3 * (x * x1 + y * y1)
    rest_x = 2 * x1 * z + y2 - y * bent - z * z * y
    rest_y = 2 * y1 * z - x2 + x * bent + z * z * x
    return (
        (0.0, 0.0, h),
        (two * y, -two * x, 0.0),
        (three * first[0], three * first[1], three * first[2]),
        (four * rest_x, four * rest_y, -four * lean),
    )


@njit(**INNER)
def _polynomials(h, frame_low, frame_high, low, high, gap):
    """Return ten coefficients by t in [0, 1] for each axis, the constant left 0.

    gap : position at the upper end less that at the lower end.
    """
    down, up = _derivatives(h, low), _derivatives(h, high)
    one, two = rotate(frame_low, down[0]), rotate(frame_low, down[1])
    three, four = rotate(frame_low, down[2]), rotate(frame_low, down[3])
    end1, end2 = rotate(frame_high, up[0]), rotate(frame_high, up[1])
    end3, end4 = rotate(frame_high, up[2]), rotate(frame_high, up[3])
    axes = (
        _close(gap[0], one[0], two[0], three[0], four[0], end1[0], end2[0], end3[0], end4[0]),
        _close(gap[1], one[1], two[1], three[1], four[1], end1[1], end2[1], end3[1], end4[1]),
        _close(gap[2], one[2], two[2], three[2], four[2], end1[2], end2[2], end3[2], end4[2]),
    )
    return axes


@njit(**INNER)
def _close(gap, one, two, three, four, end1, end2, end3, end4):
    lack = (
        gap - one - two - three - four,
        end1 - one - 2 * two - 3 * three - 4 * four,
        end2 - two - 3 * three - 6 * four,
        end3 - three - 4 * four,
        end4 - four,
    )
    high = lack
    for i in range(5):
        total = 0.0
        for k in range(5):
            total += CLOSE[i][k] * lack[k]
        high = tuple_setitem(high, i, total)
    return (0.0, one, two, three, four, high[0], high[1], high[2], high[3], high[4])


@njit(**INNER)
def sample_points(nodes, steps, places, row, points):
    """Write the points at given places.

    Parameters
    ----------
    nodes, steps : with frames placed.
    places : (k, n) rising, mm from the entry, within the robot.
    row : which configuration.
    points : (k, n, 3) written, mm in the base frame.
    """
    count = places.shape[1]
    sample = 0
    for k in range(steps - 1, -1, -1):
        start, h = nodes.place[k + 1], nodes.place[k] - nodes.place[k + 1]
        stop = sample
        while stop < count and (places[row, stop] <= nodes.place[k] or k == 0):
            stop += 1
        if stop == sample:
            continue
        px, py, pz = _step_polynomials(nodes, k, h)
        inverse = 1.0 / h
        x, y, z = nodes.frame[k + 1, 9], nodes.frame[k + 1, 10], nodes.frame[k + 1, 11]
        for i in range(sample, stop):
            t = (places[row, i] - start) * inverse
            points[row, i, 0] = x + _value(px, t)
            points[row, i, 1] = y + _value(py, t)
            points[row, i, 2] = z + _value(pz, t)
        sample = stop
    for i in range(sample, count):  # a robot drawn in completely has no step
        points[row, i, 0] = points[row, i, 1] = points[row, i, 2] = 0.0


@njit(**INNER)
def _step_polynomials(nodes, k, h):
    frame, bend = (0.0,) * 9, (0.0,) * 7
    down, up = take(frame, nodes.frame, k + 1, 0), take(frame, nodes.turning, k, 0)
    gap = (
        nodes.frame[k, 9] - nodes.frame[k + 1, 9],
        nodes.frame[k, 10] - nodes.frame[k + 1, 10],
        nodes.frame[k, 11] - nodes.frame[k + 1, 11],
    )
    low, high = take(bend, nodes.bend, k, 0), take(bend, nodes.bend, k, 7)
    return _polynomials(h, down, up, low, high, gap)


@njit(**INNER)
def _value(c, t):
    w = t * t
    low = (c[1] + t * c[2]) + w * (c[3] + t * c[4])
    high = (c[5] + t * c[6]) + w * ((c[7] + t * c[8]) + w * c[9])
    return t * (low + w * w * high)
