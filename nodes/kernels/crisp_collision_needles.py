"""Whether two needles touch one another: chains of capsules, exactly."""

from math import sqrt

from numba import njit

from nodes.kernels.crisp_collision_options import INSIDE

TINY = 1e-300  # keeps chords of no length from dividing by 0


@njit(**INSIDE)
def chains_touch(one, spared, other, reach):
    """Return whether two chains come nearer to one another than `reach`.

    From a place on the first chain, as far as the other is away beyond `reach` the first is free;
    only chords that this does not cover are held against all of the other.

    Parameters
    ----------
    one, other : (n, 3) corners.
    spared : length of the first chain, before its end, that may be as near as it likes.
    """
    clear = 0.0
    for chord in range(len(one) - 2, -1, -1):
        length = sqrt(_square(_way(one, chord)))
        if spared >= length:
            spared -= length
            continue
        start, way = (one[chord, 0], one[chord, 1], one[chord, 2]), _way(one, chord)
        if spared > 0.0:
            share = 1.0 - spared / length
            way = share * way[0], share * way[1], share * way[2]
            length, spared = share * length, 0.0
        if clear < length:
            end = start[0] + way[0], start[1] + way[1], start[2] + way[2]
            clear = sqrt(_square_to_chain(end, other)) - reach
            if clear < 0.0:
                return True
            if clear < length and _is_near_chain(start, way, other, reach * reach):
                return True
        clear = max(clear - length, 0.0)
    return False


@njit(**INSIDE)
def _square_to_chain(point, chain):
    least = _square((point[0] - chain[0, 0], point[1] - chain[0, 1], point[2] - chain[0, 2]))
    for chord in range(len(chain) - 1):
        off = point[0] - chain[chord, 0], point[1] - chain[chord, 1], point[2] - chain[chord, 2]
        least = min(least, _square_to_segment(off, _way(chain, chord)))
    return least


@njit(**INSIDE)
def _is_near_chain(start, way, chain, square):
    for chord in range(len(chain) - 1):
        off = start[0] - chain[chord, 0], start[1] - chain[chord, 1], start[2] - chain[chord, 2]
        if square_between(off, way, _way(chain, chord)) < square:
            return True
    return False


@njit(**INSIDE)
def square_between(off, one, other):
    """Return the squared distance between two segments.

    It is convex: least where the lines are nearest, if that is on both, else at one of the ends.

    Parameters
    ----------
    off : from the start of the second segment to that of the first; three numbers.
    one, other : from start to end.
    """
    end = off[0] + one[0], off[1] + one[1], off[2] + one[2]
    least = min(_square_to_segment(off, other), _square_to_segment(end, other))
    back = -off[0], -off[1], -off[2]
    beyond = other[0] - off[0], other[1] - off[1], other[2] - off[2]
    least = min(least, min(_square_to_segment(back, one), _square_to_segment(beyond, one)))
    a, b, c = _square(one), _dot(one, other), _square(other)
    d, e = _dot(one, off), _dot(other, off)
    area = a * c - b * b
    s, t = b * e - c * d, a * e - b * d  # times the area
    if area > 0.0 and 0.0 <= s <= area and 0.0 <= t <= area:
        s, t = s / area, t / area
        x = off[0] + s * one[0] - t * other[0]
        y = off[1] + s * one[1] - t * other[1]
        z = off[2] + s * one[2] - t * other[2]
        least = min(least, x * x + y * y + z * z)
    return least


@njit(**INSIDE)
def _square_to_segment(off, way):
    """Return the squared distance from a point, seen from the segment's start, to a segment."""
    share = min(max(_dot(off, way) / max(_square(way), TINY), 0.0), 1.0)
    return _square((off[0] - share * way[0], off[1] - share * way[1], off[2] - share * way[2]))


@njit(**INSIDE)
def _way(chain, chord):
    """Return the way from the start of a chord to its end."""
    return (
        chain[chord + 1, 0] - chain[chord, 0],
        chain[chord + 1, 1] - chain[chord, 1],
        chain[chord + 1, 2] - chain[chord, 2],
    )


@njit(**INSIDE)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**INSIDE)
def _square(a):
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
