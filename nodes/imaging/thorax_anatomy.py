"""The thorax that the phantom draws: sizes in mm for a chest 350 mm wide, values in HU.

Sizes and values are round numbers in the range of adults' chest CTs: a drawing, not a measurement.
Patient axes: +x left, +y posterior,
+z superior, origin in the middle of the chest.
"""

import numpy as np
from jaxtyping import Float

from nodes.imaging.solids import (
    Canvas,
    Distance,
    Points,
    Triple,
    box,
    ellipsoid,
    paint,
    shell,
    tube,
)

REFERENCE_WIDTH = 350.0
NAMES = ("body", "bone", "lungs", "airway", "effusion")
BODY, BONE, LUNGS, AIRWAY, EFFUSION = 1, 2, 3, 4, 5

AIR, FAT, MUSCLE, SOFT, BLOOD = -1000.0, -100.0, 55.0, 35.0, 45.0
LIVER, CARTILAGE, CORTEX, MARROW, SPINAL_CANAL = 60.0, 95.0, 800.0, 260.0, 25.0
FLUID, AERATED_LUNG, TABLE = 8.0, -850.0, -100.0

# Half axes of nested ellipsoids about the origin: skin, muscles, scapulae, ribs, pleura.
SKIN, MUSCLES = (175.0, 122.0, 430.0), (162.0, 112.0, 420.0)
SCAPULAE, RIBS, PLEURA = (155.0, 107.0, 260.0), (144.0, 97.0, 240.0), (134.0, 88.0, 225.0)
LOWEST, HIGHEST = -150.0, 150.0  # of the image

VERTEBRAL_PERIOD, VERTEBRAL_HEIGHT, VERTEBRAL_Y, CANAL_Y = 25.0, 20.0, 62.0, 86.0
CARINA, HILUM = (0.0, 12.0, 40.0), (40.0, 12.0, 18.0)  # hilum of the left lung
RIB_RADIUS, RIB_CORTEX, RIB_PAIRS = 5.5, 1.6, 10


def paint_trunk(canvas: Canvas) -> None:
    """Skin and fat, muscles, and the organs below the diaphragm."""
    points = canvas.points
    paint(canvas, box(points, (0, 134, 0), (220, 10, 500)), TABLE, 0)
    paint(canvas, ellipsoid(points, (0, 0, 0), SKIN), FAT, BODY)
    paint(canvas, ellipsoid(points, (0, 0, 0), MUSCLES), MUSCLE, BODY)
    inside = ellipsoid(points, (0, 0, 0), PLEURA)
    paint(canvas, np.maximum(inside, ellipsoid(points, *_dome(-1))), LIVER, BODY)
    paint(canvas, np.maximum(inside, ellipsoid(points, *_dome(1))), SOFT, BODY)
    paint(canvas, ellipsoid(points, (62, -25, -125), (28, 22, 16)), AIR, BODY)


def _dome(side: int) -> tuple[Triple, Triple]:
    """Centre and half axes of the diaphragm's dome, the right one higher (liver)."""
    return (66.0 * side, 0.0, -158.0 - 6 * side), (78.0, 100.0, 92.0 - 6 * side)


def pleural_cavity(points: Points, side: int) -> Distance:
    """Distance to one pleural cavity, right for side -1, left for 1, mm."""
    solids = [
        ellipsoid(points, (0, 0, 0), PLEURA),
        ellipsoid(points, (58.0 * side, 12, -25), (88, 118, 158)),
        -ellipsoid(points, *_dome(side)),
        -ellipsoid(points, (0, 5, 0), (27, 160, 400)),
        -ellipsoid(points, (0, VERTEBRAL_Y + 8, 0), (28, 38, 900)),
        -ellipsoid(points, (0, -10, 25), (38, 55, 70)),
        -heart(points),
        box(points, (100.0 * side, 0, 0), (100, 300, 128)),
    ]
    return np.maximum.reduce(solids)


def collapsed_lung(points: Points, side: int, share: float) -> Distance:
    """Distance to a lung that leaves `share` of its cavity free, mm.

    The lung is the cavity drawn towards its front at the hilum by the factor (1 - share)^(1/3), so
    its volume is 1 - share of the cavity's.
    """
    factor = np.float32((1 - share) ** (1 / 3))
    hold = (50.0 * side, -65.0, 25.0)
    x, y, z = (
        (p - np.float32(h)) / factor + np.float32(h) for p, h in zip(points, hold, strict=True)
    )
    return factor * pleural_cavity((x, y, z), side)


def heart(points: Points) -> Distance:
    """Distance to the heart, mm; its tip points left, forward and down."""
    left = ellipsoid(points, (28, -28, -45), (48, 42, 52))
    return np.minimum(left, ellipsoid(points, (-2, -18, -30), (42, 40, 50)))


def paint_mediastinum(canvas: Canvas) -> None:
    """Heart, aorta, and the airway down to the hila."""
    paint(canvas, heart(canvas.points), BLOOD, BODY)
    aorta = np.array([(10, -15, 0), (-2, -20, 50), (5, 0, 78), (22, 30, 70), (25, 45, 50),
                      (22, 48, -150)], float)  # fmt: skip
    distance, part = tube(canvas.points, aorta, 13.0, 2 * canvas.blend_mm)
    paint(canvas, distance, BLOOD, BODY, part)


def paint_airway(canvas: Canvas) -> None:
    """Trachea and main bronchi: walls, then the air in them."""
    trachea = np.array([(0, -2, 200), CARINA], float)
    bronchi = [np.array([CARINA, (side * HILUM[0], *HILUM[1:])], float) for side in (-1, 1)]
    courses = [(trachea, 8.5), (bronchi[0], 6.5), (bronchi[1], 6.0)]
    for wall_mm, hu, label in ((1.8, SOFT, BODY), (0.0, AIR, AIRWAY)):
        for course, radius in courses:
            distance, part = tube(canvas.points, course, radius + wall_mm, 2 * canvas.blend_mm)
            paint(canvas, distance, hu, label, part)


def paint_vessels(canvas: Canvas, side: int, chance: np.random.Generator) -> None:
    """Vessels that branch from the hilum outwards, as far as there is lung; they count as lung."""
    root = np.array([side * HILUM[0], *HILUM[1:]])
    for _ in range(12):
        stem = chance.normal(size=3) * (1, 1, 1.3)
        stem = stem / np.linalg.norm(stem) * 38
        stem[0] = side * abs(stem[0])
        for radius, start, step in _branches(root, stem, chance):
            course = np.stack([start, start + step])
            distance, part = tube(canvas.points, course, radius, 2 * canvas.blend_mm)
            outside = np.where(canvas.labels[part] == LUNGS, np.float32(-1e3), np.float32(1e3))
            paint(canvas, np.maximum(distance, outside), BLOOD, LUNGS, part)


def _branches(
    root: Float[np.ndarray, "3"], stem: Float[np.ndarray, "3"], chance: np.random.Generator
) -> list[tuple[float, Float[np.ndarray, "3"], Float[np.ndarray, "3"]]]:
    """Return radius, start and step of a stem and the branches of its three generations."""
    branches, tips = [(2.8, root, stem)], [(root + stem, stem)]
    for radius in (1.8, 1.2):
        grown = []
        for tip, step in tips:
            for _ in range(2):
                turn = 0.85 * step + chance.normal(size=3) * 14
                branches.append((radius, tip, turn))
                grown.append((tip + turn, turn))
        tips = grown
    return branches


def paint_spine(canvas: Canvas) -> None:
    """Vertebral bodies with discs between them, arches, and spinous processes."""
    x, y, z = canvas.points
    period = np.float32(VERTEBRAL_PERIOD)
    z = np.mod(z + period / 2, period) - period / 2  # every vertebra is the one at the origin
    body = ellipsoid((x, y, 0 * z), (0, VERTEBRAL_Y, 0), (17, 14, 1))
    body = np.maximum(body, abs(z) - np.float32(VERTEBRAL_HEIGHT / 2))
    canal = ellipsoid((x, y, 0 * z), (0, CANAL_Y, 0), (9.5, 8.5, 1))
    ring = ellipsoid((x, y, 0 * z), (0, CANAL_Y, 0), (15, 13, 1))
    arch = np.maximum(ring, abs(z + 2) - np.float32(8))
    spinous = box((x, y, z), (0, 102, -3), (3, 9, 5))
    transverse = box((x, y, z), (0, 87, 1), (30, 4.5, 5))
    bone = np.minimum(np.minimum(body, arch), np.minimum(spinous, transverse))
    _paint_bone(canvas, np.maximum(bone, -canal), 1.6)


def paint_ribs(canvas: Canvas) -> None:
    """Ribs, and the cartilage by which the upper seven reach the sternum."""
    for number in range(RIB_PAIRS):
        for side in (-1, 1):
            bone, cartilage = _rib(number, side)
            reach = 2 * canvas.blend_mm
            if number < 7:
                distance, part = tube(canvas.points, cartilage, RIB_RADIUS - 0.5, reach)
                paint(canvas, distance, CARTILAGE, BODY, part)
            distance, part = tube(canvas.points, bone, RIB_RADIUS, reach)
            paint(canvas, distance, CORTEX, BONE, part)
            paint(canvas, distance + np.float32(RIB_CORTEX), MARROW, BONE, part)


def _rib(number: int, side: int) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "m 3"]]:
    """Return the courses of one rib's bone and cartilage, on the ribs' ellipsoid.

    The angle runs from the spine (0) round to the sternum (pi); the rib falls while it runs, and
    its cartilage rises again to the sternum.
    """
    back = 150.0 - VERTEBRAL_PERIOD * number
    front = back - 35.0 - 5.0 * number
    attachment = max(front, 100.0 - 17.0 * number)
    angle = np.linspace(0.2, 0.76 * np.pi, 20)
    height = back + (front - back) * np.linspace(0, 1, 20) ** 0.8
    tail = np.linspace(0.76 * np.pi, 0.955 * np.pi, 8)
    rise = np.linspace(front, attachment, 8)
    return _on_cage(angle, height, side), _on_cage(tail, rise, side)


def _on_cage(
    angle: Float[np.ndarray, " n"], height: Float[np.ndarray, " n"], side: int
) -> Float[np.ndarray, "n 3"]:
    width = np.sqrt(1 - (height / RIBS[2]) ** 2)
    x, y = side * RIBS[0] * width * np.sin(angle), RIBS[1] * width * np.cos(angle)
    return np.stack([x, y, height], axis=1)


def paint_plates(canvas: Canvas) -> None:
    """Sternum and scapulae, as parts of sheets around the chest."""
    points = canvas.points
    sternum = np.maximum(
        shell(ellipsoid(points, (0, 0, 0), RIBS), 5),
        box(points, (0, -100, 45), (17, 40, 75)),
    )
    _paint_bone(canvas, sternum, 1.5)
    sheet = shell(ellipsoid(points, (0, 0, 0), SCAPULAE), 3.5)
    for side in (-1, 1):
        blade = ellipsoid(points, (100.0 * side, 78, 85), (48, 60, 62))
        _paint_bone(canvas, np.maximum(sheet, blade), 1.5)


def _paint_bone(canvas: Canvas, distance: Distance, cortex_mm: float) -> None:
    paint(canvas, distance, CORTEX, BONE)
    paint(canvas, distance + np.float32(cortex_mm), MARROW, BONE)
