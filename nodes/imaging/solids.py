"""Distances to simple solids, and painting solids into an image with partial volume.

All distances are negative inside and, near the surface, right to first order: an implicit function
over the length of its gradient [Taubin1994]. Solids meet by `np.maximum` and join by `np.minimum`.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32, UInt8

Points = tuple[
    Float32[np.ndarray, "_ 1 1"], Float32[np.ndarray, "1 _ 1"], Float32[np.ndarray, "1 1 _"]
]
Distance = Float32[np.ndarray, "_ _ _"]
Box = tuple[slice, slice, slice]
Number = float | int
Triple = tuple[Number, Number, Number]

EVERYWHERE: Box = (slice(None), slice(None), slice(None))


class Canvas(NamedTuple):
    """An image being painted: x, y and z of the voxels in mm, values in HU, labels, and the width
    in mm over which a surface blends into what lies behind it."""

    points: Points
    hu: Float32[np.ndarray, "i j k"]
    labels: UInt8[np.ndarray, "i j k"]
    blend_mm: float


def paint(
    canvas: Canvas, distance: Distance, hu: Number, label: int, box: Box = EVERYWHERE
) -> None:
    """Fill a solid: the label where a voxel's centre is inside, the value by the share inside."""
    share = np.clip(np.float32(0.5) - distance / np.float32(canvas.blend_mm), 0, 1)
    view = canvas.hu[box]
    view += share * (np.float32(hu) - view)
    canvas.labels[box][np.broadcast_to(distance < 0, view.shape)] = label


def ellipsoid(points: Points, centre: Triple, radii: Triple) -> Distance:
    """Distance to the ellipsoid with these half axes, mm."""
    inverse = [np.float32(1 / radius) for radius in radii]
    x, y, z = ((p - np.float32(c)) * i for p, c, i in zip(points, centre, inverse, strict=True))
    level = np.sqrt(x * x + y * y + z * z)
    slope = np.sqrt((x * inverse[0]) ** 2 + (y * inverse[1]) ** 2 + (z * inverse[2]) ** 2)
    return level * (level - 1) / np.maximum(slope, np.float32(1e-6))


def box(points: Points, centre: Triple, half: Triple) -> Distance:
    """Distance to the nearest face of a box, mm."""
    x, y, z = (
        abs(p - np.float32(c)) - np.float32(h) for p, c, h in zip(points, centre, half, strict=True)
    )
    return np.maximum(np.maximum(x, y), z)


def shell(distance: Distance, half_thickness: Number) -> Distance:
    """Distance to a sheet around the surface of another solid, mm."""
    return abs(distance) - np.float32(half_thickness)


def tube(
    points: Points, course: Float[np.ndarray, "n 3"], radius: Number, reach: Number
) -> tuple[Distance, Box]:
    """Distance to a tube with round ends around a polyline, within `reach` of it, mm.

    Returns
    -------
    The distance in the returned part of the image; beyond the reach of the tube it is large.
    """
    around = _box_around(points, course, radius + reach)
    local = _cut(points, around)
    distance = np.full(tuple(p.size for p in local), np.float32(1e3))
    for start, end in pairwise(course):
        part = _box_around(local, np.stack([start, end]), radius + reach)
        view = distance[part]
        np.minimum(view, _from_segment(_cut(local, part), start, end), out=view)
    return distance - np.float32(radius), around


def _box_around(points: Points, course: Float[np.ndarray, "n 3"], margin: float) -> Box:
    low, high = course.min(axis=0) - margin, course.max(axis=0) + margin
    first = [int(np.searchsorted(p.ravel(), lo)) for p, lo in zip(points, low, strict=True)]
    last = [int(np.searchsorted(p.ravel(), hi)) for p, hi in zip(points, high, strict=True)]
    return (slice(first[0], last[0]), slice(first[1], last[1]), slice(first[2], last[2]))


def _cut(points: Points, box: Box) -> Points:
    return points[0][box[0]], points[1][:, box[1]], points[2][:, :, box[2]]


def _from_segment(
    points: Points, start: Float[np.ndarray, "3"], end: Float[np.ndarray, "3"]
) -> Distance:
    along = (end - start).astype(np.float32)
    offsets = [p - np.float32(s) for p, s in zip(points, start, strict=True)]
    share = sum(o * a for o, a in zip(offsets, along, strict=True)) / np.float32(along @ along)
    share = np.clip(share, 0, 1)
    return np.sqrt(sum((o - share * a) ** 2 for o, a in zip(offsets, along, strict=True)))
