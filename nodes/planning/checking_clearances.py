"""How near needles come to the anatomy along a motion, also between the solved configurations.

The distance from a point to the anatomy changes by no more than the point moves. From the distances
d at both ends of a piece of a needle, in two configurations after each other, that bounds it from
below for all of the piece and all of the time between; pieces are halved until the bound is near
enough or it does not matter.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from nodes.planning.checking_boxes import Boxes, bound_distances, measure_distances
from nodes.planning.checking_shapes import Course
from nodes.planning.parameters import CheckCrispPlansParameters

CHUNK = 200  # configurations at once: their points take some MB


class Clearances(NamedTuple):
    """From each configuration to the next; a single one to itself.

    Parameters
    ----------
    least_mm : (pair,) at most the clearance of the needle's surface: all of it beyond the longest
        sheath, and of what lies before only what is too near.
    arcs_mm : (pair,) where on the needle that is, mm from its entry point.
    sheaths_mm : (pair,) how much of the needle lies in the sheath.
    """

    least_mm: np.ndarray
    arcs_mm: np.ndarray
    sheaths_mm: np.ndarray


class _Pieces(NamedTuple):
    """Pieces of a needle in a pair of configurations.

    Parameters
    ----------
    pair, place : (m,) number of the pair, and of the sample before the piece.
    start, end : (m,) shares of the way from that sample to the next.
    low, high : (m,) bounds of the distance at both ends, over the time between, mm.
    """

    pair: np.ndarray
    place: np.ndarray
    start: np.ndarray
    end: np.ndarray
    low: np.ndarray
    high: np.ndarray


def measure_clearances(
    course: Course, radius_mm: float, boxes: Boxes, parameters: CheckCrispPlansParameters
) -> Clearances:
    """Return lower bounds of a needle's clearance, at most `accuracy_mm` too small between samples
    in time, and where it must be told apart from `margin_mm`."""
    if len(course.points) == 1:  # a motion of one step stands still
        course = Course(*(np.repeat(values, 2, axis=0) for values in course))
    found = [
        _measure(Course(*(v[first : first + CHUNK + 1] for v in course)), radius_mm, boxes,
                 parameters)
        for first in range(0, len(course.points) - 1, CHUNK)
    ]  # fmt: skip
    return Clearances(*(np.concatenate(values) for values in zip(*found, strict=True)))


def _measure(
    course: Course, radius: float, boxes: Boxes, parameters: CheckCrispPlansParameters
) -> Clearances:
    distances = _find_distances(course, radius, boxes, parameters)
    leaves = _leave_sheath(course.arcs_mm, distances - radius, parameters)
    first = np.minimum(leaves[:-1], leaves[1:])
    moved = np.linalg.norm(np.diff(course.points, axis=0), axis=2)
    held = (distances[:-1] + distances[1:] - moved) / 2
    pair, place = np.nonzero(np.arange(held.shape[1] - 1) >= first[:, None])
    pieces = _Pieces(
        pair, place, np.zeros(len(pair)), np.ones(len(pair)),
        held[pair, place], held[pair, place + 1],
    )  # fmt: skip
    least, where = _search(pieces, course, radius, boxes, parameters)
    sheaths = np.take_along_axis(course.arcs_mm[:-1], first[:, None], axis=1)[:, 0]
    return Clearances(least - radius, where, sheaths)


def _find_distances(
    course: Course, radius: float, boxes: Boxes, parameters: CheckCrispPlansParameters
) -> Float[np.ndarray, "c q"]:
    """Return the distances of all samples; lower bounds of those that are too far to matter."""
    points = course.points.reshape(-1, 3)
    shape = course.arcs_mm.shape
    low, high = (each.reshape(shape) for each in bound_distances(points, boxes))
    tells = _are_beyond(course.arcs_mm, parameters)
    least = np.where(tells, high, np.inf).min(axis=1, keepdims=True)
    spacing = np.diff(course.arcs_mm, axis=1).max()
    enough = np.maximum(least, radius + max(parameters.clear_mm, parameters.margin_mm))
    near = low < enough + 2 * spacing
    low[near] = measure_distances(points[near.ravel()], boxes)
    return low


def _are_beyond(arcs: np.ndarray, parameters: CheckCrispPlansParameters) -> np.ndarray:
    """Return which places lie beyond the longest sheath; of a short needle at least the tip."""
    return arcs >= np.minimum(parameters.sheath_mm, arcs[..., -1:])


def _leave_sheath(
    arcs: Float[np.ndarray, "c q"],
    clearances: Float[np.ndarray, "c q"],
    parameters: CheckCrispPlansParameters,
) -> Int[np.ndarray, "c"]:
    """Return at which sample each configuration's needle leaves its sheath: the first that is clear
    of the anatomy, or the last that the longest sheath holds."""
    clear = clearances >= max(parameters.clear_mm, parameters.margin_mm)
    free = np.where(clear.any(axis=1), clear.argmax(axis=1), arcs.shape[1])
    held = np.maximum((arcs <= parameters.sheath_mm).sum(axis=1) - 1, 0)
    return np.minimum(free, held)


def _search(
    pieces: _Pieces,
    course: Course,
    radius: float,
    boxes: Boxes,
    parameters: CheckCrispPlansParameters,
) -> tuple[Float[np.ndarray, "pair"], Float[np.ndarray, "pair"]]:
    """Return the least bound of each pair and where it is, halving pieces that may hold less."""
    pairs = len(course.points) - 1
    least, where = np.full(pairs, np.inf), np.zeros(pairs)
    wanted = radius + parameters.margin_mm
    while len(pieces.pair):
        arcs = _arcs(pieces, course)
        lengths = _lengths(pieces, course)
        bounds = (pieces.low + pieces.high - lengths) / 2
        beyond = arcs >= np.minimum(parameters.sheath_mm, course.arcs_mm[pieces.pair, -1])
        known = np.full(pairs, np.inf)
        np.minimum.at(known, pieces.pair[beyond], np.minimum(pieces.low, pieces.high)[beyond])
        known = np.minimum(known, least + parameters.accuracy_mm)
        enough = np.where(beyond, known[pieces.pair] - parameters.accuracy_mm, wanted)
        done = (bounds >= enough) | (lengths <= parameters.accuracy_mm)
        counts = done & (beyond | (bounds < wanted))
        _keep_least(least, where, pieces.pair[counts], bounds[counts], arcs[counts])
        pieces = _halve(_Pieces(*(values[~done] for values in pieces)), course, boxes)
    return least, where


def _keep_least(
    least: np.ndarray, where: np.ndarray, pair: np.ndarray, bounds: np.ndarray, arcs: np.ndarray
) -> None:
    """Put the least bound of each pair, and its place, where it is less than what is known."""
    order = np.lexsort((arcs, bounds, pair))
    firsts = order[np.unique(pair[order], return_index=True)[1]]
    better = firsts[bounds[firsts] < least[pair[firsts]]]
    least[pair[better]], where[pair[better]] = bounds[better], arcs[better]


def _halve(pieces: _Pieces, course: Course, boxes: Boxes) -> _Pieces:
    """Return both halves of each piece, the distances in the middle measured."""
    if not len(pieces.pair):
        return pieces
    middle = (pieces.start + pieces.end) / 2
    one = _interpolate(course, pieces.pair, pieces.place, middle)
    other = _interpolate(course, pieces.pair + 1, pieces.place, middle)
    near = measure_distances(one, boxes) + measure_distances(other, boxes)
    held = (near - np.linalg.norm(other - one, axis=1)) / 2
    halves = (
        pieces._replace(end=middle, high=held),
        pieces._replace(start=middle, low=held),
    )
    return _Pieces(*(np.concatenate(both) for both in zip(*halves, strict=True)))


def _arcs(pieces: _Pieces, course: Course) -> Float[np.ndarray, "m"]:
    """Return where pieces begin, mm from the entry point, in the first of both configurations."""
    before = course.arcs_mm[pieces.pair, pieces.place]
    after = course.arcs_mm[pieces.pair, pieces.place + 1]
    return before + pieces.start * (after - before)


def _lengths(pieces: _Pieces, course: Course) -> Float[np.ndarray, "m"]:
    """Return by how much the bound may change along pieces, mm: their length, and how differently
    their ends move."""
    share = pieces.end - pieces.start
    longest = np.zeros(len(share))
    for row in (pieces.pair, pieces.pair + 1):
        length = course.arcs_mm[row, pieces.place + 1] - course.arcs_mm[row, pieces.place]
        longest = np.maximum(longest, length)
    apart = _moved(course, pieces.pair, pieces.place + 1) - _moved(
        course, pieces.pair, pieces.place
    )
    return share * (longest + np.linalg.norm(apart, axis=1))


def _moved(course: Course, pair: np.ndarray, place: np.ndarray) -> Float[np.ndarray, "m 3"]:
    """Return how samples move from one configuration to the next."""
    return course.points[pair + 1, place] - course.points[pair, place]


def _interpolate(
    course: Course, row: np.ndarray, place: np.ndarray, share: np.ndarray
) -> Float[np.ndarray, "m 3"]:
    """Return points between samples, of the cubic with their places and tangents."""
    u, length = share[:, None], course.arcs_mm[row, place + 1] - course.arcs_mm[row, place]
    ends = course.points[row, place], course.points[row, place + 1]
    slopes = course.tangents[row, place], course.tangents[row, place + 1]
    straight = (1 + 2 * u) * (1 - u) ** 2 * ends[0] + (3 - 2 * u) * u**2 * ends[1]
    bent = u * (1 - u) ** 2 * slopes[0] - u**2 * (1 - u) * slopes[1]
    return straight + length[:, None] * bent
