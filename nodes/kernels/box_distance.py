"""How near segments come to boxes along the axes."""

from numba import njit

from nodes.kernels.crisp_collision_options import INSIDE

SEARCHES = 60  # of the nearest place; a handful suffice, since each lies on a piece of parabola


@njit(**INSIDE)
def is_near_box(start, way, low, high, radius):
    """Return whether a segment comes nearer to a box than `radius`.

    The distance to a box is convex along the segment, and its square a chain of parabolas: Newton's
    method on the slope ends on the right one, and tangents bound the distance from below before.

    Parameters
    ----------
    start, way : three numbers each: where the segment starts, and from there to its end.
    low, high : corners of the box, three numbers each.
    """
    share, first, last = 0.5, -1.0, 2.0  # beyond the ends, until these are looked at
    square = radius * radius
    for _ in range(SEARCHES):
        x = _beyond(start[0] + share * way[0], low[0], high[0])
        y = _beyond(start[1] + share * way[1], low[1], high[1])
        z = _beyond(start[2] + share * way[2], low[2], high[2])
        height = x * x + y * y + z * z
        if height < square:
            return True
        slope = x * way[0] + y * way[1] + z * way[2]
        if slope > 0.0:
            last = share
            least = height - slope * (share - max(first, 0.0))
        else:
            first = share
            least = height + slope * (min(last, 1.0) - share)
        if slope == 0.0 or (least > 0.0 and least * least >= square * height):
            return False
        bend = _active(x, way[0]) + _active(y, way[1]) + _active(z, way[2])
        share = min(max(share - slope / bend, 0.0), 1.0)
        if not first < share < last:
            share = 0.5 * (max(first, 0.0) + min(last, 1.0))
    return False


@njit(**INSIDE)
def _beyond(place, low, high):
    """Return how far a place lies beyond an interval, with sign; 0 within."""
    return min(place - low, 0.0) + max(place - high, 0.0)


@njit(**INSIDE)
def _active(beyond, way):
    return way * way if beyond != 0.0 else 0.0
