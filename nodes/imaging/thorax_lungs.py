"""Lungs of the phantom with their airways and vessels, and one collapsed in fluid.

The collapsed lung is its healthy self, drawn towards an anchor by a factor: at the hilum's height,
beside the spine, so that it keeps to the mediastinum and lies on the posterior side of the fluid,
as in [Kuntz2017] Fig. 3. (Without adhesions fluid would pool behind an aerated lung in a patient on
his back; `lung_lies` can put the lung in front.) Where fluid would be a thinner film than asked
for, the lung lies on the wall: a small effusion is a layer at one place, no film around the lung.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, UInt8

from nodes.geometry.masks import Mask, bounding_box, grow_mask, largest_part
from nodes.imaging.painting import Canvas, paint
from nodes.imaging.solids import (
    Distance,
    Solid,
    Triple,
    box,
    cut,
    ellipsoid,
    join,
    narrow,
    scale_towards,
    tube,
)
from nodes.imaging.thorax_anatomy import (
    AIR,
    BODY,
    EFFUSION,
    FAT,
    LEFT,
    LEFT_LUNG,
    PLEURA,
    RIGHT_LUNG,
    Build,
    dome,
    mediastinum,
)

FLUID, AERATED_LUNG = 8.0, -850.0
CARINA, HILUM = (0.0, 12.0, 40.0), (40.0, 12.0, 18.0)  # hilum of the left lung
ANCHORS = {"posterior": (30.0, 66.0, 12.0), "anterior": (34.0, -68.0, 12.0)}  # of the left lung
STALK_RADIUS = 18.0  # of what joins hilum and mediastinum
SHARE_GRID = 4.0  # mm, on which the share of the fluid is set


class Collapse(NamedTuple):
    """How far a lung is drawn in: to `factor` of its length, towards `anchor`, but where that
    leaves a gap narrower than `film` it stays on the wall; all in mm."""

    factor: float
    anchor: Triple
    film: float

    def move(self, course: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
        """Return where points of the healthy lung are now."""
        return np.array(self.anchor) + self.factor * (course - np.array(self.anchor))


HEALTHY = Collapse(1.0, (0.0, 0.0, 0.0), 0.0)


def lung_label(side: int) -> int:
    """Return the label of the lung on a side."""
    return LEFT_LUNG if side == LEFT else RIGHT_LUNG


def pleural_cavity(side: int, build: Build) -> Solid:
    """One pleural cavity with all that is in it."""
    bounds = ellipsoid((58.0 * side, 12, -25), (88 * build.lung, 118, 152 + build.apex_mm))
    half = box((100.0 * side, 0, 0), (100, 300, 132))
    return cut(
        [ellipsoid((0, 0, 0), PLEURA), bounds, half], [dome(side, build), *mediastinum(build)]
    )


def lung(side: int, build: Build, collapse: Collapse) -> Solid:
    """One lung, with the stalk by which it hangs on the hilum."""
    cavity = pleural_cavity(side, build)
    if collapse == HEALTHY:
        return cavity
    hilum = np.array([side * HILUM[0], *HILUM[1:]])
    inner = hilum - (12.0 * side, 0, 0)
    stalk = tube(np.stack([inner, hilum, collapse.move(hilum[None])[0]]), STALK_RADIUS)
    small = scale_towards(cavity, collapse.anchor, collapse.factor)
    return cut([join([small, narrow(small, cavity, collapse.film), *stalk]), cavity])


def draw_in(side: int, build: Build, lies: str, share: float, film: float) -> Collapse:
    """Return the collapse that leaves `share` of a cavity free, by bisection of the volume.

    The volume is that on a grid of its own, so that it does not change with the image's.
    """
    if share == 0:
        return HEALTHY
    x, y, z = ANCHORS[lies]
    anchor = (side * x, y, z)
    cavity = pleural_cavity(side, build)
    points = _grid(cavity)
    whole = _volume(cavity.distance(points))
    low, high = 0.1, 1.0
    for _ in range(14):
        middle = (low + high) / 2
        left = _volume(lung(side, build, Collapse(middle, anchor, film)).distance(points)) / whole
        low, high = (low, middle) if left > 1 - share else (middle, high)
    return Collapse((low + high) / 2, anchor, film)


def _grid(solid: Solid) -> tuple[Distance, Distance, Distance]:
    """Return the points of a grid that lie in a solid or next to it, as columns."""
    sides = [np.arange(a, b, SHARE_GRID) for a, b in zip(solid.low, solid.high, strict=True)]
    places = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3, 1, 1)
    x, y, z = np.moveaxis(places.astype(np.float32), 1, 0)
    near = solid.distance((x, y, z)).ravel() < SHARE_GRID
    return x[near], y[near], z[near]


def _volume(distance: Distance) -> float:
    return float(np.count_nonzero(distance < 0))


def paint_lungs(canvas: Canvas, build: Build, ill: int, collapse: Collapse, share: float) -> None:
    """Paint the healthy lung, and the other one drawn together within its fluid.

    A collapsed lung holds the same tissue in less space, so its density grows by 1/(1 - share).
    """
    paint(canvas, [pleural_cavity(-ill, build)], AERATED_LUNG, lung_label(-ill))
    if share > 0:
        paint(canvas, [pleural_cavity(ill, build)], FLUID, EFFUSION)
    tissue = (AERATED_LUNG - AIR) / (1 - share)
    within = FLUID if share > 0 else None
    paint(canvas, [lung(ill, build, collapse)], AIR + tissue, lung_label(ill), instead_of=within)
    _drop_islands(canvas, lung_label(-ill), FAT, BODY)
    _drop_islands(canvas, lung_label(ill), *((FLUID, EFFUSION) if share > 0 else (FAT, BODY)))


def _drop_islands(canvas: Canvas, label: int, hu: float, other: int) -> None:
    """Give to what lies around it the lung that other organs have cut off."""
    islands = find_islands(canvas.labels, label)
    if islands.any():
        around = grow_mask(islands, max(canvas.spacing), np.array(canvas.spacing))
        canvas.labels[islands] = other
        canvas.hu[around & (canvas.labels == other)] = hu


def find_islands(labels: UInt8[np.ndarray, "i j k"], label: int) -> Mask:
    """Return the voxels of a label outside of its largest part."""
    mask = labels == label
    box = bounding_box(mask)
    islands = np.zeros_like(mask)
    islands[box] = mask[box] & ~largest_part(mask[box])
    return islands
