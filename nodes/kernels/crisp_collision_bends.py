"""How far bent rods lie from the chords between points on them."""

from math import sqrt

from numba import njit

from nodes.kernels.crisp_collision_options import INSIDE

SLACK = 1.15  # for what is left when the curvature is taken as linear between neighbouring chords
TINY = 1e-300  # chords of no length do not turn


@njit(**INSIDE)
def turn_at(points, place):
    """Return the turn from the chord before a point to the one after it: axis times angle, rad."""
    ax = points[place, 0] - points[place - 1, 0]
    ay = points[place, 1] - points[place - 1, 1]
    az = points[place, 2] - points[place - 1, 2]
    bx = points[place + 1, 0] - points[place, 0]
    by = points[place + 1, 1] - points[place, 1]
    bz = points[place + 1, 2] - points[place, 2]
    both = sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
    rate = 2.0 / max(both + ax * bx + ay * by + az * bz, TINY)  # 2 tan(a/2) = 2 sin a / (1 + cos a)
    return (ay * bz - az * by) * rate, (az * bx - ax * bz) * rate, (ax * by - ay * bx) * rate


@njit(**INSIDE)
def turn_at_corner(points, place, first, pieces):
    """Return the turn, as the curvature there times a piece's length, at any corner of a rod.

    The moment in a rod is linear in the place along it, and so, nearly, is the curvature: at its
    ends, where chords of another rod or none follow, it is what the next two corners lead to.

    Parameters
    ----------
    first : corner where the rod starts.
    """
    if place == first:
        near, far = turn_at(points, first + 1), turn_at(points, first + 2)
    elif place == first + pieces:
        near, far = turn_at(points, place - 1), turn_at(points, place - 2)
    else:
        return turn_at(points, place)
    return 2.0 * near[0] - far[0], 2.0 * near[1] - far[1], 2.0 * near[2] - far[2]


@njit(**INSIDE)
def chord_turn(points, chord, first, pieces):
    """Return a bound of the angle by which a rod turns along one chord, rad: the curvature is not
    larger than at the ends."""
    a = turn_at_corner(points, chord, first, pieces)
    b = turn_at_corner(points, chord + 1, first, pieces)
    return SLACK * sqrt(max(_square(a), _square(b)))


@njit(**INSIDE)
def rod_turn(points, first, pieces):
    """Return the same bound for all chords of a rod."""
    most = _square(turn_at_corner(points, first, first, pieces))
    most = max(most, _square(turn_at_corner(points, first + pieces, first, pieces)))
    for place in range(first + 1, first + pieces):
        most = max(most, _square(turn_at(points, place)))
    return SLACK * sqrt(most)


@njit(**INSIDE)
def _square(a):
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
