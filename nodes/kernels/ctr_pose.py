"""Pose along the robot from its torsion: Magnus series of order 6 in rigid motions.

Each step is integrated in a frame that turns evenly, about as fast as the curvature's direction:
what is left changes little, and one curved tube alone bends into an exact helix. A curvature
(C, Z), pointing where it bends to, is the body's rotation vector (-Z, C) by arc length.
"""

from numba import njit
from numba.cpython.unsafe.tuple import tuple_setitem

from nodes.kernels.ctr_options import INNER
from nodes.kernels.ctr_rotations import cross, move, multiply, rotate, turn
from nodes.kernels.ctr_sincos import sincos
from nodes.kernels.ctr_tuples import put, take


@njit(**INNER)
def bend_in_innermost(share, drive, weights, rate, sine, cosine):
    """Return C, Z, C', Z', C'', Z'' in the innermost tube's frame, its psi' and psi'', and the
    second and third derivatives of the angles to it.

    Parameters
    ----------
    share, drive, weights : of all tubes.
    rate, sine, cosine : of the angles of the others to the innermost.
    """
    c, z, c1, z1, c2, z2 = share[0], 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(rate)):
        c += share[i + 1] * cosine[i]
        z += share[i + 1] * sine[i]
        c1 -= share[i + 1] * sine[i] * rate[i]
        z1 += share[i + 1] * cosine[i] * rate[i]
    twist, bent, seconds, thirds = 0.0, 0.0, rate, rate
    for i in range(len(rate)):
        second = drive[i + 1] * (sine[i] * c - cosine[i] * z) + drive[0] * z
        third = (cosine[i] * c + sine[i] * z) * rate[i] + sine[i] * c1 - cosine[i] * z1
        seconds = tuple_setitem(seconds, i, second)
        thirds = tuple_setitem(thirds, i, drive[i + 1] * third + drive[0] * z1)
        c2 -= share[i + 1] * (sine[i] * second + cosine[i] * rate[i] * rate[i])
        z2 += share[i + 1] * (cosine[i] * second - sine[i] * rate[i] * rate[i])
        twist -= weights[i + 1] * rate[i]
        bent -= weights[i + 1] * second
    return (c, z, c1, z1, c2, z2, twist, bent), seconds, thirds


@njit(**INNER)
def halfway(h, low, low_rate, low_second, low_third, high, high_rate, high_second, high_third):
    """Return angles and rates in the middle of a step of length h, by the polynomial of degree 7
    through values and three derivatives at both ends."""
    g = h * h
    angle, rate = low, low
    for i in range(len(low)):
        value = (low[i] + high[i]) / 2 + 11 / 64 * h * (low_rate[i] - high_rate[i])
        value += 3 / 128 * g * (low_second[i] + high_second[i])
        value += 1 / 768 * g * h * (low_third[i] - high_third[i])
        angle = tuple_setitem(angle, i, value)
        value = 35 / 16 * (high[i] - low[i]) / h - 19 / 32 * (low_rate[i] + high_rate[i])
        value += 1 / 16 * h * (high_second[i] - low_second[i])
        value -= 1 / 384 * g * (low_third[i] + high_third[i])
        rate = tuple_setitem(rate, i, value)
    return angle, rate


@njit(**INNER)
def turning_rate(low, high):
    """Return how fast the curvature's direction turns, the mean of both ends by its square."""
    much = low[0] * low[0] + low[1] * low[1] + high[0] * high[0] + high[1] * high[1]
    if much == 0.0:
        return 0.0
    turned = _turned(low) + _turned(high)
    return turned / much


@njit(**INNER)
def _turned(bend):
    c, z, c1, z1, _, _, twist, _ = bend
    return c * z1 - z * c1 + twist * (c * c + z * z)


@njit(**INNER)
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


@njit(**INNER)
def advance(h, low, high, frame, place):
    """Return frame and place after a step from those before and u, u', u'' at its two ends.

    low, high : (x, y, rate, x', y', x'', y''): the frame turns evenly, so u_z is constant.

    Moments of the quintic through both ends, B_k = int (t - 1/2)^k u dt, give the generators of the
    Magnus series of order 6 [Blanes2009], here for motions that multiply on the right.
    """
    one, two, three = (0.0, 0.0, h * low[2]), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(2):
        a, b = h * (low[3 + i] - high[3 + i]), h * (low[3 + i] + high[3 + i])
        p, q = h * h * (low[5 + i] + high[5 + i]), h * h * (high[5 + i] - low[5 + i])
        total, gap = low[i] + high[i], high[i] - low[i]
        b0 = total / 2 + a / 10 + p / 120
        b1 = gap * (3 / 28) - b / 84 + q / 1680
        b2 = total / 24 + a / 210 + p / 3360
        one = tuple_setitem(one, i, h * (9 / 4 * b0 - 15 * b2))
        two = tuple_setitem(two, i, 12 * h * b1)
        three = tuple_setitem(three, i, h * (180 * b2 - 15 * b0))
    # Only `one` moves along the tangent; brackets of (w, v) are (b x a, b x v_a - a x v_b).
    e3 = (0.0, 0.0, h)
    c1, d1 = cross(two, one), cross(two, e3)
    inner = add3(three, 2.0, c1, 1.0)
    c2, d2 = cross(inner, one), _minus(cross(inner, e3), cross(one, d1))
    left, left_v = _left(one, three, c1), (d1[0], d1[1], d1[2] - 20.0 * h)
    right, right_v = add3(two, 1.0, c2, -1 / 60), _scale(-1 / 60, d2)
    c3 = cross(right, left)
    d3 = _minus(cross(right, left_v), cross(left, right_v))
    w, v = one, e3
    for i in range(3):
        w = tuple_setitem(w, i, one[i] + three[i] / 12 + c3[i] / 240)
        v = tuple_setitem(v, i, e3[i] + d3[i] / 240)
    rotation, translation = move(w, v)
    step = rotate(frame, translation)
    place = (place[0] + step[0], place[1] + step[1], place[2] + step[2])
    return multiply(frame, rotation), place


@njit(**INNER)
def move_on(w, h, frame, place):
    """Return frame and place after an even step of length h that turns by w."""
    rotation, translation = move(w, (0.0, 0.0, h))
    step = rotate(frame, translation)
    return multiply(frame, rotation), (place[0] + step[0], place[1] + step[1], place[2] + step[2])


@njit(**INNER)
def mean_swing(weights, before, after):
    """Return how far the innermost tube turns while the others' angles to it change."""
    swing = 0.0
    for i in range(len(before)):
        swing += weights[i + 1] * (before[i] - after[i])
    return swing


@njit(**INNER)
def add3(a, factor, b, other):
    """Return factor * a + other * b."""
    return (
        factor * a[0] + other * b[0],
        factor * a[1] + other * b[1],
        factor * a[2] + other * b[2],
    )


@njit(**INNER)
def _scale(factor, a):
    return factor * a[0], factor * a[1], factor * a[2]


@njit(**INNER)
def _minus(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(**INNER)
def _left(one, three, c1):
    return add3(add3(one, -20.0, three, -1.0), 1.0, c1, 1.0)


@njit(**INNER)
def place_frames(size, weights, beta, theta, sections, nodes, steps):
    """Write the innermost tube's frame at all nodes and return its angle at the entry and the tip.

    Parameters
    ----------
    size, weights : tuples as long as the angles and as the tubes.
    beta, theta : translation mm and rotation rad of the innermost tube.
    sections, nodes, steps : solved; `nodes.frame` and `nodes.bend` are written.
    """
    angle, rate = take(size, nodes.state, steps, 0), take(size, nodes.rate, steps, 0)
    entry = theta
    for i in range(len(size)):
        entry += beta * weights[i + 1] * rate[i]
    sine, cosine = sincos(entry)
    frame = (cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0)
    place = (0.0, 0.0, 0.0)
    put(frame, nodes.frame, steps, 0)
    put(place, nodes.frame, steps, 9)
    sines, cosines = all_sincos(angle)
    tip = entry
    for k in range(steps - 1, -1, -1):
        share = take(weights, sections.share, nodes.section[k], 0)
        drive = take(weights, sections.drive, nodes.section[k], 0)
        low, second, third = bend_in_innermost(share, drive, weights, rate, sines, cosines)
        before, rate_before = angle, rate
        angle, rate = take(size, nodes.state, k, 0), take(size, nodes.rate, k, 0)
        sines, cosines = all_sincos(angle)
        high, seconds, thirds = bend_in_innermost(share, drive, weights, rate, sines, cosines)
        h, even = nodes.place[k] - nodes.place[k + 1], turning_rate(low, high)
        swing = mean_swing(weights, before, angle)
        sine, cosine = sincos(even * h - swing)
        low = bend_in_turning(low, even, 0.0, 1.0)
        high = bend_in_turning(high, even, sine, cosine)
        if sections.coupled[nodes.section[k]]:
            middle, middle_rate = halfway(
                h, before, rate_before, second, third, angle, rate, seconds, thirds
            )
            one, other = all_sincos(middle)
            half, _, _ = bend_in_innermost(share, drive, weights, middle_rate, one, other)
            lag, lead = sincos(even * h / 2 - mean_swing(weights, before, middle))
            half = bend_in_turning(half, even, lag, lead)
            frame, place = advance(h / 2, low, half, frame, place)
            frame, place = advance(h / 2, half, high, frame, place)
        else:  # one curved tube: the frame turns with it, and the curvature stands still
            frame, place = move_on((h * low[0], h * low[1], h * even), h, frame, place)
        put(low, nodes.bend, k, 0)
        put(high, nodes.bend, k, 7)
        put(frame, nodes.turning, k, 0)
        frame = turn(frame, -sine, cosine)
        put(frame, nodes.frame, k, 0)
        put(place, nodes.frame, k, 9)
        tip += swing
    return entry, tip


@njit(**INNER)
def all_sincos(angles):
    """Return the sines and the cosines of some angles."""
    sines, cosines = angles, angles
    for i in range(len(angles)):
        one, other = sincos(angles[i])
        sines, cosines = tuple_setitem(sines, i, one), tuple_setitem(cosines, i, other)
    return sines, cosines
