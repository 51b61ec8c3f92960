"""Painting solids into an image with partial volume.

A voxel that a surface crosses is cut into small parts, and holds the share of them that is inside:
so an edge is right for voxels of any shape, as it is in a scanner with thick slices.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float32, Int, UInt8

from nodes.imaging.solids import Number, Points, Solid, Triple

Box = tuple[slice, slice, slice]

FAR = np.float32(1e3)  # stands for "not near", mm
# A voxel at an edge is cut into parts of this size, but in no more than so many of its mean size.
FINE_MM, MOST_PARTS = 0.8, 3


class Canvas(NamedTuple):
    """An image to paint on: voxel centres along each axis, what is there, and where solids live.

    `bend` maps points of the image to the frame in which the solids are given.
    """

    axes: tuple[Float32[np.ndarray, " i"], Float32[np.ndarray, " j"], Float32[np.ndarray, " k"]]
    spacing: Triple
    bend: Callable[[Points], Points]
    hu: Float32[np.ndarray, "i j k"]
    labels: UInt8[np.ndarray, "i j k"]


def paint(
    canvas: Canvas,
    solids: Sequence[Solid],
    hu: Number,
    label: int | None = None,
    only: tuple[int, ...] | None = None,
    instead_of: Number | None = None,
) -> None:
    """Fill the union of solids: the label where a voxel's centre is inside, the value by the share
    of the voxel that is inside.

    Without a label the labels stay; with `only`, nothing but voxels of these labels is changed.
    What is filled displaces all that is in a voxel alike, or, with `instead_of`, the part with this
    value alone: for solids that lie within what was painted before, that is exact.
    """
    reach = 0.6 * float(np.linalg.norm(canvas.spacing))  # half a diagonal, and some for the bend
    extents = _extents(canvas)
    boxes = [_box_around(extents, solid, reach) for solid in solids]
    local = [(solid, box) for solid, box in zip(solids, boxes, strict=True) if _holds_voxels(box)]
    if not local:
        return
    whole = _hull([box for _, box in local])
    distance = np.full(canvas.hu[whole].shape, FAR)
    for solid, box in local:
        inner = _relative(box, whole)
        np.minimum(distance[inner], solid.distance(_points(canvas, box)), out=distance[inner])
    share = (distance < 0).astype(np.float32)
    near = abs(distance) < np.float32(reach)
    share[near] = _share_inside(canvas, local, whole, near)
    inside = distance < 0
    if only is not None:
        allowed = np.isin(canvas.labels[whole], only)
        share, inside = share * allowed, inside & allowed
    values = canvas.hu[whole]
    values += share * (np.float32(hu) - (values if instead_of is None else np.float32(instead_of)))
    if label is not None:
        canvas.labels[whole][inside] = label


def _share_inside(
    canvas: Canvas,
    local: Sequence[tuple[Solid, Box]],
    whole: Box,
    near: Bool[np.ndarray, "i j k"],
) -> Float32[np.ndarray, " n"]:
    """Return the share of each near voxel that is inside, from the distances of its parts."""
    fine = max(FINE_MM, float(np.cbrt(np.prod(canvas.spacing))) / MOST_PARTS)
    counts = [int(np.ceil(step / fine)) for step in canvas.spacing]
    offsets = _offsets(counts, canvas.spacing)
    places = np.argwhere(near) + [side.start for side in whole]
    number = np.full(near.shape, -1, np.int32)
    number[near] = np.arange(len(places))
    distance = np.full((len(places), len(offsets), 1), FAR)
    for solid, box in local:
        chosen = number[_relative(box, whole)]
        chosen = chosen[chosen >= 0]
        points = _parts(canvas, places[chosen], offsets)
        distance[chosen] = np.minimum(distance[chosen], solid.distance(canvas.bend(points)))
    size = np.float32(np.cbrt(np.prod(np.array(canvas.spacing) / counts)))
    return np.clip(np.float32(0.5) - distance / size, 0, 1).mean(axis=(1, 2))


def _offsets(counts: Sequence[int], spacing: Triple) -> Float32[np.ndarray, "m 3"]:
    """Return the centres of a voxel's parts about the centre of the voxel, mm."""
    sides = [
        ((np.arange(n) + 0.5) / n - 0.5) * step for n, step in zip(counts, spacing, strict=True)
    ]
    grid = np.meshgrid(*sides, indexing="ij")
    return np.stack([side.ravel() for side in grid], axis=1).astype(np.float32)


def _parts(
    canvas: Canvas, places: Int[np.ndarray, "n 3"], offsets: Float32[np.ndarray, "m 3"]
) -> Points:
    x, y, z = (
        (axis[places[:, a], None] + offsets[:, a])[:, :, None] for a, axis in enumerate(canvas.axes)
    )
    return x, y, z


def _points(canvas: Canvas, box: Box) -> Points:
    x, y, z = (axis[side] for axis, side in zip(canvas.axes, box, strict=True))
    return canvas.bend((x[:, None, None], y[None, :, None], z[None, None, :]))


def _extents(canvas: Canvas) -> list[tuple[Float32[np.ndarray, " _"], Float32[np.ndarray, " _"]]]:
    """Return for each axis the smallest and the largest coordinate of each of its planes."""
    x, y, z = canvas.axes
    bent = canvas.bend((x[:, None, None], y[None, :, None], z[None, None, :]))
    others = [(1, 2), (0, 2), (0, 1)]
    return [(p.min(axis=o), p.max(axis=o)) for p, o in zip(bent, others, strict=True)]


def _box_around(
    extents: list[tuple[Float32[np.ndarray, " _"], Float32[np.ndarray, " _"]]],
    solid: Solid,
    reach: float,
) -> Box:
    """Return the voxels that a solid and its surroundings can lie in."""
    sides = []
    for (smallest, largest), low, high in zip(extents, solid.low, solid.high, strict=True):
        inside = np.flatnonzero((largest >= low - reach) & (smallest <= high + reach))
        sides.append(slice(int(inside[0]), int(inside[-1]) + 1) if len(inside) else slice(0, 0))
    return (sides[0], sides[1], sides[2])


def _holds_voxels(box: Box) -> bool:
    return all(side.stop > side.start for side in box)


def _hull(boxes: Sequence[Box]) -> Box:
    x, y, z = (
        slice(min(side.start for side in sides), max(side.stop for side in sides))
        for sides in zip(*boxes, strict=True)
    )
    return x, y, z


def _relative(box: Box, whole: Box) -> Box:
    x, y, z = (
        slice(side.start - outer.start, side.stop - outer.start)
        for side, outer in zip(box, whole, strict=True)
    )
    return x, y, z
