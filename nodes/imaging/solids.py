"""Distances to simple solids, and how solids join, meet and are cut.

All distances are negative inside and, near the surface, right to first order: an implicit function
over the length of its gradient [Taubin1994].
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32

Coordinates = Float32[np.ndarray, "_ _ _"]  # of shapes that broadcast against each other
Points = tuple[Coordinates, Coordinates, Coordinates]
Distance = Float32[np.ndarray, "_ _ _"]
Number = float | int
Triple = tuple[Number, Number, Number]


class Solid(NamedTuple):
    """A solid as its distance, mm, and the box that holds it."""

    distance: Callable[[Points], Distance]
    low: Triple
    high: Triple


def ellipsoid(centre: Triple, radii: Triple) -> Solid:
    """An ellipsoid with these half axes, mm."""
    inverse = [np.float32(1 / radius) for radius in radii]

    def distance(points):
        x, y, z = ((p - np.float32(c)) * i for p, c, i in zip(points, centre, inverse, strict=True))
        level = np.sqrt(x * x + y * y + z * z)
        slope = np.sqrt((x * inverse[0]) ** 2 + (y * inverse[1]) ** 2 + (z * inverse[2]) ** 2)
        return level * (level - 1) / np.maximum(slope, np.float32(1e-6))

    return Solid(distance, *_around(centre, radii))


def box(centre: Triple, half: Triple) -> Solid:
    """A box, by the distance to its nearest face, mm."""

    def distance(points):
        x, y, z = (
            abs(p - np.float32(c)) - np.float32(h)
            for p, c, h in zip(points, centre, half, strict=True)
        )
        return np.maximum(np.maximum(x, y), z)

    return Solid(distance, *_around(centre, half))


def tube(course: Float[np.ndarray, "n 3"], radius: Number, height: Number = 1.0) -> list[Solid]:
    """Return the pieces of a tube with round ends around a polyline; `height` times as high along
    z as it is wide."""
    return [_piece(start, end, float(radius), float(height)) for start, end in pairwise(course)]


def _piece(
    start: Float[np.ndarray, "3"], end: Float[np.ndarray, "3"], radius: float, height: float
) -> Solid:
    squeeze = np.array([1, 1, 1 / height], np.float32)
    along = ((end - start) * squeeze).astype(np.float32)
    length = np.float32(max(along @ along, 1e-6))

    def distance(points):
        x, y, z = ((p - np.float32(s)) * f for p, s, f in zip(points, start, squeeze, strict=True))
        share = np.clip((x * along[0] + y * along[1] + z * along[2]) / length, 0, 1)
        x, y, z = x - share * along[0], y - share * along[1], z - share * along[2]
        return np.sqrt(x * x + y * y + z * z) - np.float32(radius)

    margin = np.array([radius, radius, radius * height])
    low, high = np.minimum(start, end) - margin, np.maximum(start, end) + margin
    return Solid(distance, _triple(low), _triple(high))


def join(solids: Sequence[Solid]) -> Solid:
    """All that is in any of the solids."""

    def distance(points):
        found = solids[0].distance(points)
        for solid in solids[1:]:
            found = np.minimum(found, solid.distance(points))
        return found

    low = np.min([solid.low for solid in solids], axis=0)
    return Solid(distance, _triple(low), _triple(np.max([s.high for s in solids], axis=0)))


def cut(solids: Sequence[Solid], away: Sequence[Solid] = ()) -> Solid:
    """All that is in every one of the solids, without what is to be cut away."""

    def distance(points):
        found = solids[0].distance(points)
        for solid in solids[1:]:
            found = np.maximum(found, solid.distance(points))
        for solid in away:
            found = np.maximum(found, -solid.distance(points))
        return found

    low = np.max([solid.low for solid in solids], axis=0)
    return Solid(distance, _triple(low), _triple(np.min([s.high for s in solids], axis=0)))


def narrow(inner: Solid, outer: Solid, width: Number) -> Solid:
    """Where the gap between two surfaces, one around the other, is narrower than this.

    The gap's width changes slowly along it, so the distance to where it has this width is longer
    than told: across the gap's end values blend over less than a voxel.
    """

    def distance(points):
        return inner.distance(points) - outer.distance(points) - np.float32(width)

    return Solid(distance, outer.low, outer.high)


def shell(solid: Solid, half_thickness: Number) -> Solid:
    """A sheet around the surface of another solid."""

    def distance(points):
        return abs(solid.distance(points)) - np.float32(half_thickness)

    margin = 2 * half_thickness
    return Solid(
        distance, _triple(np.subtract(solid.low, margin)), _triple(np.add(solid.high, margin))
    )


def shrink(solid: Solid, depth: Number) -> Solid:
    """What lies deeper than this under the surface of another solid."""

    def distance(points):
        return solid.distance(points) + np.float32(depth)

    return Solid(distance, solid.low, solid.high)


def scale_towards(solid: Solid, anchor: Triple, factor: Number) -> Solid:
    """A solid drawn towards a point by a factor."""

    def distance(points):
        x, y, z = (
            (p - np.float32(a)) / np.float32(factor) + np.float32(a)
            for p, a in zip(points, anchor, strict=True)
        )
        return np.float32(factor) * solid.distance((x, y, z))

    low, high = (
        np.array(anchor) + factor * (np.array(corner) - anchor)
        for corner in (solid.low, solid.high)
    )
    return Solid(distance, _triple(low), _triple(high))


def _around(centre: Triple, half: Triple) -> tuple[Triple, Triple]:
    return _triple(np.subtract(centre, half)), _triple(np.add(centre, half))


def _triple(values: np.ndarray) -> Triple:
    return (float(values[0]), float(values[1]), float(values[2]))
