"""How near needles come to one another along a motion, but where one grasps the other."""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from nodes.mechanics.robots import CrispSetup
from nodes.planning.checking_shapes import Course
from nodes.planning.parameters import CheckCrispPlansParameters

CHUNK = 50  # configurations at once
Points = Float[np.ndarray, "n 3"]


class Gap(NamedTuple):
    """Between the surfaces of two needles.

    Parameters
    ----------
    needles : which two.
    least_mm : (c,) at most the gap in each configuration and half-way to those beside it.
    """

    needles: tuple[int, int]
    least_mm: np.ndarray


def measure_gaps(
    setup: CrispSetup, courses: tuple[Course, ...], parameters: CheckCrispPlansParameters
) -> list[Gap]:
    """Return lower bounds of the gaps between all pairs of needles."""
    gaps, moved = [], [_half_ways(course) for course in courses]
    for one, other in combinations(range(len(courses)), 2):
        # A snare's last part may touch the tool, which it grasps.
        grasp = parameters.grasp_mm if one == 0 else 0.0
        radii = sum(setup.needles[needle].outer_diameter_mm for needle in (one, other)) / 2
        least = [
            _measure(
                _cut(courses[one], moved[one], first),
                _cut(courses[other], moved[other], first),
                grasp,
            )
            for first in range(0, len(courses[one].points), CHUNK)
        ]
        gaps.append(Gap((one, other), np.concatenate(least) - radii))
    return gaps


class _Part(NamedTuple):
    """A needle in some configurations, and how far its points (c, q) move half-way to the
    configurations before and after."""

    course: Course
    moved: np.ndarray


def _cut(course: Course, moved: Float[np.ndarray, "c q"], first: int) -> _Part:
    rows = slice(first, first + CHUNK)
    return _Part(Course(*(values[rows] for values in course)), moved[rows])


def _half_ways(course: Course) -> Float[np.ndarray, "c q"]:
    ways = np.zeros((len(course.points) + 1, course.points.shape[1]))
    ways[1:-1] = np.linalg.norm(np.diff(course.points, axis=0), axis=2) / 2
    return np.maximum(ways[:-1], ways[1:])


def _measure(one: _Part, other: _Part, grasp: float) -> Float[np.ndarray, "c"]:
    """Return the least distance of two axes in each configuration, less what they may be nearer
    between the samples in arc length and in time."""
    points, others = one.course.points, other.course.points
    square = (points**2).sum(axis=2)[:, :, None] + (others**2).sum(axis=2)[:, None]
    away = np.sqrt(np.maximum(square - 2 * points @ np.swapaxes(others, 1, 2), 0.0))
    nearest = np.minimum(
        np.minimum(away[:, 1:, 1:], away[:, 1:, :-1]),
        np.minimum(away[:, :-1, 1:], away[:, :-1, :-1]),
    )
    arcs = other.course.arcs_mm
    free = arcs < arcs[:, -1:] - grasp
    nearest = np.where(free[:, None, :-1], nearest, np.inf)
    slack = sum(np.diff(part.course.arcs_mm, axis=1).max() + 2 * part.moved.max()
                for part in (one, other))  # fmt: skip
    least = nearest.min(axis=(1, 2), initial=np.inf)
    row, a, b = np.nonzero(nearest <= least[:, None, None] + 2 * slack)
    start, end, off = _chords(one, row, a)
    other_start, other_end, other_off = _chords(other, row, b)
    held = arcs[row, -1] - grasp - arcs[row, b]
    share = np.minimum(held / (arcs[row, b + 1] - arcs[row, b]), 1.0)
    other_end = other_start + share[:, None] * (other_end - other_start)
    gaps = _between_lines(start, end, other_start, other_end) - off - other_off
    found = np.full(len(points), np.inf)
    np.minimum.at(found, row, gaps)
    return found


def _chords(
    part: _Part, row: np.ndarray, place: np.ndarray
) -> tuple[Points, Points, Float[np.ndarray, "n"]]:
    """Return ends of chords, and how far the needle may be from them: where it bends, and while it
    moves."""
    arcs, points, tangents = part.course
    turned = np.linalg.norm(tangents[row, place + 1] - tangents[row, place], axis=1)
    # An arc that turns by little leaves its chord by an eighth of length times turn; twice that.
    bent = (arcs[row, place + 1] - arcs[row, place]) * turned / 4
    moved = np.maximum(part.moved[row, place], part.moved[row, place + 1])
    return points[row, place], points[row, place + 1], bent + moved


def _between_lines(a: Points, b: Points, c: Points, d: Points) -> Float[np.ndarray, "n"]:
    """Return the distances between the straight lines from a to b and from c to d."""
    ends = [_to_line(a, c, d), _to_line(b, c, d), _to_line(c, a, b), _to_line(d, a, b)]
    least = np.min(ends, axis=0)
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = (u * u).sum(axis=1), (u * v).sum(axis=1), (v * v).sum(axis=1)
    uw, vw = (u * w).sum(axis=1), (v * w).sum(axis=1)
    across = uu * vv - uv**2
    skew = across > 0
    across = np.where(skew, across, 1.0)
    s, t = (uv * vw - vv * uw) / across, (uu * vw - uv * uw) / across
    inner = skew & (s > 0) & (s < 1) & (t > 0) & (t < 1)
    gap = np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1)
    return np.where(inner, np.minimum(gap, least), least)


def _to_line(point: Points, start: Points, end: Points) -> Float[np.ndarray, "n"]:
    """Return the distances from points to straight lines between two ends."""
    way, size = end - start, ((end - start) ** 2).sum(axis=1)
    share = ((point - start) * way).sum(axis=1) / np.where(size > 0, size, 1.0)
    nearest = start + np.clip(share, 0.0, 1.0)[:, None] * way
    return np.linalg.norm(point - nearest, axis=1)
