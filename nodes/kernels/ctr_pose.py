"""Motion along each step from its torsion: Magnus series of order 6 in rigid motions.

Eight steps go through it at once, as lanes. Each is integrated in a frame that turns evenly, about
as fast as the curvature's direction: what is left changes little, and one curved tube alone bends
into an exact helix. A curvature (C, Z), pointing where it bends to, is the body's rotation vector
(-Z, C) by arc length.
"""

from numba import njit

from nodes.kernels.ctr_lanes import load_rows, store_rows
from nodes.kernels.ctr_nodes import HIGH_BEND, INPUTS, LOW_BEND, MOTION, TURNING
from nodes.kernels.ctr_options import INNER, INSIDE
from nodes.kernels.ctr_rotations import cross, move, multiply, rotate, turn
from nodes.kernels.ctr_sincos import all_sincos, sincos
from nodes.kernels.ctr_tuples import replace

TINY = 1e-300  # keeps 0 / 0 from being nothing


@njit(**INSIDE)
def bend_in_innermost(share, drive, weights, rate, sine, cosine):
    """Return C, Z, C', Z', C'', Z'' in the innermost tube's frame, its psi' and psi'', and the
    second and third derivatives of the angles to it.

    Parameters
    ----------
    share, drive, weights : of all tubes.
    rate, sine, cosine : of the angles of the others to the innermost.
    """
    c, z = share[0] + share[1] * cosine[0], share[1] * sine[0]
    c1, z1 = -share[1] * sine[0] * rate[0], share[1] * cosine[0] * rate[0]
    for i in range(1, len(rate)):
        c += share[i + 1] * cosine[i]
        z += share[i + 1] * sine[i]
        c1 -= share[i + 1] * sine[i] * rate[i]
        z1 += share[i + 1] * cosine[i] * rate[i]
    seconds, thirds = rate, rate
    for i in range(len(rate)):
        second = drive[i + 1] * (sine[i] * c - cosine[i] * z) + drive[0] * z
        third = (cosine[i] * c + sine[i] * z) * rate[i] + sine[i] * c1 - cosine[i] * z1
        seconds = replace(seconds, i, second)
        thirds = replace(thirds, i, drive[i + 1] * third + drive[0] * z1)
    twist, bent = -weights[1] * rate[0], -weights[1] * seconds[0]
    square = rate[0] * rate[0]
    c2 = -share[1] * (sine[0] * seconds[0] + cosine[0] * square)
    z2 = share[1] * (cosine[0] * seconds[0] - sine[0] * square)
    for i in range(1, len(rate)):
        square = rate[i] * rate[i]
        c2 -= share[i + 1] * (sine[i] * seconds[i] + cosine[i] * square)
        z2 += share[i + 1] * (cosine[i] * seconds[i] - sine[i] * square)
        twist -= weights[i + 1] * rate[i]
        bent -= weights[i + 1] * seconds[i]
    return (c, z, c1, z1, c2, z2, twist, bent), seconds, thirds


@njit(**INSIDE)
def halfway(h, low, low_rate, low_second, low_third, high, high_rate, high_second, high_third):
    """Return angles and rates in the middle of a step of length h, by the polynomial of degree 7
    through values and three derivatives at both ends."""
    g = h * h
    inverse = 1.0 / h
    angle, rate = low, low
    for i in range(len(low)):
        value = 1 / 2 * (low[i] + high[i]) + 11 / 64 * h * (low_rate[i] - high_rate[i])
        value += 3 / 128 * g * (low_second[i] + high_second[i])
        value += 1 / 768 * g * h * (low_third[i] - high_third[i])
        angle = replace(angle, i, value)
        value = 35 / 16 * inverse * (high[i] - low[i]) - 19 / 32 * (low_rate[i] + high_rate[i])
        value += 1 / 16 * h * (high_second[i] - low_second[i])
        value -= 1 / 384 * g * (low_third[i] + high_third[i])
        rate = replace(rate, i, value)
    return angle, rate


@njit(**INSIDE)
def turning_rate(low, high):
    """Return how fast the curvature's direction turns, the mean of both ends by its square."""
    much = low[0] * low[0] + low[1] * low[1] + high[0] * high[0] + high[1] * high[1]
    return (_turned(low) + _turned(high)) / (much + TINY)


@njit(**INSIDE)
def _turned(bend):
    c, z, c1, z1, _, _, twist, _ = bend
    return c * z1 - z * c1 + twist * (c * c + z * z)


@njit(**INSIDE)
def bend_in_turning(bend, rate, sine, cosine):
    """Return (-Z, C, rate) and the first two derivatives of (-Z, C) in the evenly turning frame.

    rate : of that frame; sine, cosine : of its angle to the innermost tube's.
    """
    c, z, c1, z1, c2, z2, twist, bent = bend
    p, q = rate - twist, -bent
    c2, z2 = c2 + 2 * p * z1 + q * z - p * p * c, z2 - 2 * p * c1 - q * c - p * p * z
    c1, z1 = c1 + p * z, z1 - p * c
    c, z = cosine * c + sine * z, cosine * z - sine * c
    c1, z1 = cosine * c1 + sine * z1, cosine * z1 - sine * c1
    c2, z2 = cosine * c2 + sine * z2, cosine * z2 - sine * c2
    return -z, c, rate, -z1, c1, -z2, c2


@njit(**INSIDE)
def generate(h, low, high):
    """Return the generators of the motion over a step from u, u', u'' at its two ends.

    low, high : u, u' and u'' across one axis of the frame, which turns evenly about the tangent.

    Moments of the quintic through both ends, B_k = int (t - 1/2)^k u dt, give the generators of the
    Magnus series of order 6 [Blanes2009], here for motions that multiply on the right.
    """
    a, b = h * (low[1] - high[1]), h * (low[1] + high[1])
    p, q = h * h * (low[2] + high[2]), h * h * (high[2] - low[2])
    total, gap = low[0] + high[0], high[0] - low[0]
    b0 = total * (1 / 2) + a * (1 / 10) + p * (1 / 120)
    b1 = gap * (3 / 28) - b * (1 / 84) + q * (1 / 1680)
    b2 = total * (1 / 24) + a * (1 / 210) + p * (1 / 3360)
    return h * (9 / 4 * b0 - 15 * b2), 12 * h * b1, h * (180 * b2 - 15 * b0)


@njit(**INSIDE)
def advance(h, low, high):
    """Return rotation and translation over a step from (x, y, rate, x', y', x'', y'') of u at its
    two ends."""
    one_x, two_x, three_x = generate(h, (low[0], low[3], low[5]), (high[0], high[3], high[5]))
    one_y, two_y, three_y = generate(h, (low[1], low[4], low[6]), (high[1], high[4], high[6]))
    one = (one_x, one_y, h * low[2])
    # Only `one` moves along the tangent, by h; brackets of (w, v) are (b x a, b x v_a - a x v_b).
    c1 = _cross_flat(two_x, two_y, one)
    d1_x, d1_y = h * two_y, -h * two_x
    inner = (2.0 * three_x + c1[0], 2.0 * three_y + c1[1], c1[2])
    c2 = cross(inner, one)
    f = _cross_flat(d1_x, d1_y, one)  # - one x d1
    d2 = (h * inner[1] + f[0], f[1] - h * inner[0], f[2])
    left = (c1[0] - 20.0 * one[0] - three_x, c1[1] - 20.0 * one[1] - three_y, c1[2] - 20.0 * one[2])
    left_v = (d1_x, d1_y, -20.0 * h)
    right = (two_x - c2[0] * (1 / 60), two_y - c2[1] * (1 / 60), c2[2] * (-1 / 60))
    right_v = (d2[0] * (-1 / 60), d2[1] * (-1 / 60), d2[2] * (-1 / 60))
    c3, d3, d4 = cross(right, left), cross(right, left_v), cross(right_v, left)
    w = (
        one[0] + three_x * (1 / 12) + c3[0] * (1 / 240),
        one[1] + three_y * (1 / 12) + c3[1] * (1 / 240),
        one[2] + c3[2] * (1 / 240),
    )
    v = (
        (d3[0] + d4[0]) * (1 / 240),
        (d3[1] + d4[1]) * (1 / 240),
        h + (d3[2] + d4[2]) * (1 / 240),
    )
    return move(w, v)


@njit(**INSIDE)
def _cross_flat(x, y, b):
    return y * b[2], -x * b[2], x * b[1] - y * b[0]


@njit(**INSIDE)
def mean_swing(weights, before, after):
    """Return how far the innermost tube turns while the others' angles to it change."""
    swing = weights[1] * (before[0] - after[0])
    for i in range(1, len(before)):
        swing += weights[i + 1] * (before[i] - after[i])
    return swing


@njit(**INNER)
def gather_steps(size, weights, first, last, sections, nodes, block):
    """Write what integration needs of steps first to last - 1 to `nodes.lanes`, step by step."""
    m, lanes = len(size), nodes.lanes
    row = block + INPUTS
    for k in range(first, last):
        section, lane = nodes.section[k], k - first
        lanes[block, lane] = nodes.place[k] - nodes.place[k + 1]
        for i in range(m):
            lanes[row + i, lane] = nodes.state[k + 1, i]
            lanes[row + m + i, lane] = nodes.rate[k + 1, i]
            lanes[row + 2 * m + i, lane] = nodes.state[k, i]
            lanes[row + 3 * m + i, lane] = nodes.rate[k, i]
        for i in range(m + 1):
            lanes[row + 4 * m + i, lane] = sections.share[section, i]
            lanes[row + 5 * m + 1 + i, lane] = sections.drive[section, i]


@njit(**INNER)
def move_steps(size, weights, lanes, block):
    """Write motions of the innermost tube's frame over eight steps, and bends at their ends."""
    m, row = len(size), block + INPUTS
    (h,) = load_rows((0.0,), lanes, block)
    low, low_rate = load_rows(size, lanes, row), load_rows(size, lanes, row + m)
    high, high_rate = load_rows(size, lanes, row + 2 * m), load_rows(size, lanes, row + 3 * m)
    share = load_rows(weights, lanes, row + 4 * m)
    drive = load_rows(weights, lanes, row + 5 * m + 1)
    sines, cosines = all_sincos(low)
    down, second, third = bend_in_innermost(share, drive, weights, low_rate, sines, cosines)
    sines, cosines = all_sincos(high)
    up, seconds, thirds = bend_in_innermost(share, drive, weights, high_rate, sines, cosines)
    middle, rate = halfway(h, low, low_rate, second, third, high, high_rate, seconds, thirds)
    sines, cosines = all_sincos(middle)
    half, _, _ = bend_in_innermost(share, drive, weights, rate, sines, cosines)
    even = turning_rate(down, up)
    sine, cosine = sincos(even * h - mean_swing(weights, low, high))
    lag, lead = sincos(even * h * 0.5 - mean_swing(weights, low, middle))
    down = bend_in_turning(down, even, 0.0, 1.0)
    half = bend_in_turning(half, even, lag, lead)
    up = bend_in_turning(up, even, sine, cosine)
    rotation, first = advance(h * 0.5, down, half)
    other, second_part = advance(h * 0.5, half, up)
    more = rotate(rotation, second_part)
    turning = multiply(rotation, other)
    store_rows(turn(turning, -sine, cosine), lanes, block + MOTION)
    place = (first[0] + more[0], first[1] + more[1], first[2] + more[2])
    store_rows(place, lanes, block + MOTION + 9)
    store_rows(turning, lanes, block + TURNING)
    store_rows(down, lanes, block + LOW_BEND)
    store_rows(up, lanes, block + HIGH_BEND)
