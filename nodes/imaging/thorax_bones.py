"""Bones of the phantom: a hard rim around marrow. Sizes in mm, as in `thorax_anatomy`."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from nodes.imaging.painting import Canvas, paint
from nodes.imaging.solids import Points, Solid, box, cut, ellipsoid, join, shell, shrink, tube
from nodes.imaging.thorax_anatomy import (
    BODY,
    BONE,
    CANAL_Y,
    LEFT,
    RIBS,
    RIGHT,
    SCAPULAE,
    VERTEBRAL_Y,
    Build,
    along_spine,
)

CARTILAGE, CORTEX, MARROW = 95.0, 800.0, 260.0
VERTEBRAL_PERIOD, VERTEBRAL_HEIGHT = 25.0, 20.0
RIB_PAIRS, JOINED_TO_STERNUM = 11, 7
RIB_RADIUS, RIB_HEIGHT = 4.0, 1.6  # half of its thickness, and how much higher than thick it is
RIB_CORTEX, FLAT_CORTEX, VERTEBRAL_CORTEX = 1.4, 1.5, 1.6


def paint_ribs(canvas: Canvas, build: Build) -> None:
    """Ribs, and the cartilage by which the upper seven reach the sternum."""
    for number in range(RIB_PAIRS):
        for side in (RIGHT, LEFT):
            bone, cartilage = _rib(number, side, build.rib_slope)
            if number < JOINED_TO_STERNUM:
                paint(canvas, tube(cartilage, RIB_RADIUS - 0.3, RIB_HEIGHT), CARTILAGE, BODY)
            _paint_bone(canvas, tube(bone, RIB_RADIUS, RIB_HEIGHT), RIB_CORTEX)


def _rib(
    number: int, side: int, slope: float
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "m 3"]]:
    """Return the courses of one rib's bone and cartilage, on the ribs' ellipsoid.

    The angle runs from the spine (0) round to the sternum (pi); the rib falls while it runs, and
    its cartilage rises again to the sternum.
    """
    back = 150.0 - VERTEBRAL_PERIOD * number
    front = back - (35.0 + 5.0 * number) * slope
    attachment = max(front, 100.0 - 17.0 * number)
    bony = 0.76 if number < JOINED_TO_STERNUM + 3 else 0.5  # the last ends at the side
    angle = np.linspace(0.2, bony * np.pi, 10)
    height = back + (front - back) * np.linspace(0, 1, 10) ** 0.8
    tail = np.linspace(bony * np.pi, 0.955 * np.pi, 5)
    rise = np.linspace(front, attachment, 5)
    return _on_cage(angle, height, side), _on_cage(tail, rise, side)


def _on_cage(
    angle: Float[np.ndarray, " n"], height: Float[np.ndarray, " n"], side: int
) -> Float[np.ndarray, "n 3"]:
    width = np.sqrt(np.clip(1 - (height / RIBS[2]) ** 2, 0.05, 1))
    x, y = side * RIBS[0] * width * np.sin(angle), RIBS[1] * width * np.cos(angle)
    return np.stack([x, y, height], axis=1)


def paint_plates(canvas: Canvas) -> None:
    """Sternum, collar bones, and scapulae as parts of sheets around the chest."""
    sheet = shell(ellipsoid((0, 0, 0), RIBS), 5)
    _paint_bone(canvas, [cut([sheet, box((0, -100, 45), (17, 40, 75))])], FLAT_CORTEX)
    sheet = shell(ellipsoid((0, 0, 0), SCAPULAE), 3.5)
    for side in (RIGHT, LEFT):
        blade = ellipsoid((100.0 * side, 78, 85), (48, 60, 62))
        _paint_bone(canvas, [cut([sheet, blade])], FLAT_CORTEX)
        collar = [(20, -84, 124), (55, -86, 134), (95, -68, 146), (125, -40, 160)]
        course = np.array(collar, float) * (side, 1, 1)
        _paint_bone(canvas, tube(course, 5.5), FLAT_CORTEX)


def paint_spine(canvas: Canvas, build: Build) -> None:
    """Vertebral bodies with discs between them, arches, and their processes, bent as the spine."""
    discs = along_spine(ellipsoid((0, VERTEBRAL_Y, 0), (17, 14, 9000)), build)
    paint(canvas, [discs], CARTILAGE, BODY)
    canal = ellipsoid((0, CANAL_Y, 0), (9.5, 8.5, 9000))
    body = cut([ellipsoid((0, VERTEBRAL_Y, 0), (17, 14, 9000)), _slab(0.0, VERTEBRAL_HEIGHT)])
    arch = cut([ellipsoid((0, CANAL_Y, 0), (15, 13, 9000)), _slab(-2.0, 16.0)])
    spinous, transverse = box((0, 102, -3), (3, 9, 5)), box((0, 87, 1), (30, 4.5, 5))
    bone = _repeated(cut([join([body, arch, spinous, transverse])], [canal]))
    _paint_bone(canvas, [along_spine(bone, build)], VERTEBRAL_CORTEX)


def _slab(middle: float, height: float) -> Solid:
    return box((0, 0, middle), (200, 200, height / 2))


def _repeated(vertebra: Solid) -> Solid:
    """The spine: every vertebra is the one at the origin."""
    period = np.float32(VERTEBRAL_PERIOD)

    def distance(points: Points) -> np.ndarray:
        x, y, z = points
        return vertebra.distance((x, y, np.mod(z + period / 2, period) - period / 2))

    return Solid(distance, (*vertebra.low[:2], -9000.0), (*vertebra.high[:2], 9000.0))


def _paint_bone(canvas: Canvas, solids: Sequence[Solid], cortex_mm: float) -> None:
    paint(canvas, solids, CORTEX, BONE)
    paint(canvas, [shrink(solid, cortex_mm) for solid in solids], MARROW, BONE, instead_of=CORTEX)
