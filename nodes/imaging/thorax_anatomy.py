"""The thorax that the phantom draws: sizes in mm for a chest 350 mm wide, values in HU.

Sizes and values are round numbers in the range of adults' chest CTs: a drawing, not a measurement.
Patient axes: +x left, +y posterior, +z superior, origin in the middle of the chest; side 1 is the
left, -1 the right.
"""

from typing import NamedTuple

import numpy as np

from nodes.imaging.painting import Canvas, paint
from nodes.imaging.solids import Points, Solid, Triple, box, cut, ellipsoid, join, shell, tube

REFERENCE_WIDTH = 350.0
NAMES = ("body", "bone", "left_lung", "right_lung", "airway", "effusion", "adhesion")
BODY, BONE, LEFT_LUNG, RIGHT_LUNG, AIRWAY, EFFUSION, ADHESION = 1, 2, 3, 4, 5, 6, 7
LEFT, RIGHT = 1, -1

AIR, FAT, MUSCLE, SOFT, BLOOD = -1000.0, -100.0, 55.0, 35.0, 45.0
LIVER, SPLEEN, WATER, TABLE = 60.0, 50.0, 5.0, -100.0

# Half axes of nested ellipsoids about the origin.
SKIN, MUSCLES, FAT_SHEET = (175.0, 122.0, 430.0), (162.0, 112.0, 420.0), (150.5, 103.5, 250.0)
SCAPULAE, RIBS, PLEURA = (155.0, 107.0, 260.0), (144.0, 97.0, 240.0), (134.0, 88.0, 225.0)
LOWEST, HIGHEST = -150.0, 150.0  # of the image

VERTEBRAL_Y, CANAL_Y = 62.0, 86.0
# Largest change of each number of `Build` at full variation.
RANGES = (0.1, 4.0, 0.3, 4.0, 0.12, 7.0, 8.0, 8.0, 0.3, 0.06, 4.0)


class Build(NamedTuple):
    """What differs from one person to the next, beside size; the values are the average build."""

    depth: float = 1.0  # of the chest, against its width
    sway_mm: float = 0.0  # of the spine to the left above and to the right below
    kyphosis: float = 0.6  # how far the spine follows the chest's curve: 0 straight, 1 all
    fat_mm: float = 0.0  # under the skin, more than 13 at the side
    heart: float = 1.0  # size
    heart_left_mm: float = 0.0  # shift
    right_dome_mm: float = 0.0  # height
    left_dome_mm: float = 0.0
    rib_slope: float = 1.0
    lung: float = 1.0  # breadth
    apex_mm: float = 0.0  # height


def draw_build(variation: float, seed: int) -> Build:
    """Draw a build: each number at most its range times `variation` from the average."""
    chance = np.random.default_rng([seed, 1])  # apart from the noise's
    changes = chance.uniform(-1, 1, len(RANGES)) * RANGES * variation
    return Build(*(float(value + change) for value, change in zip(Build(), changes, strict=True)))


def bend(points: Points, build: Build) -> Points:
    """Map points of this person to the average chest that the solids are given in."""
    x, y, z = points
    sway = np.float32(build.sway_mm) * np.sin(z / np.float32(75))
    return x - sway, y / np.float32(build.depth), z


def paint_trunk(canvas: Canvas, build: Build) -> None:
    """Table, skin and fat, muscles, the organs below the diaphragm, and fat between the lungs."""
    half = 10 / build.depth  # of the table's height; its top touches the back of any build
    paint(canvas, [box((0, SKIN[1] + half, 0), (220, half, 500))], TABLE, 0)
    paint(canvas, [ellipsoid((0, 0, 0), SKIN)], FAT, BODY)
    muscles = (MUSCLES[0] - build.fat_mm, MUSCLES[1] - build.fat_mm, MUSCLES[2])
    paint(canvas, [ellipsoid((0, 0, 0), muscles)], MUSCLE, BODY)
    paint(canvas, [shell(ellipsoid((0, 0, 0), FAT_SHEET), 1.2)], FAT, BODY)
    inside = ellipsoid((0, 0, 0), PLEURA)
    paint(canvas, [cut([inside, ellipsoid((0, 0, -20), (95, 100, 160))])], FAT, BODY)
    paint(canvas, [cut([inside, dome(RIGHT, build)])], LIVER, BODY)
    paint(canvas, [cut([inside, dome(LEFT, build)])], SPLEEN, BODY)
    stomach = (62.0, -25.0, -128.0 + build.left_dome_mm)
    paint(canvas, [ellipsoid(stomach, (32, 26, 20))], SOFT, BODY)
    paint(canvas, [ellipsoid(stomach, (28, 22, 16))], AIR, BODY)


def dome(side: int, build: Build) -> Solid:
    """One half of the diaphragm, the right one higher (liver)."""
    height = 92.0 + (build.left_dome_mm - 6 if side == LEFT else build.right_dome_mm + 6)
    return ellipsoid((66.0 * side, 0.0, -158.0), (78.0, 100.0, height))


def spine_shift(z: np.ndarray, build: Build) -> np.ndarray:
    """How far the spine lies behind its place at the middle of the chest, mm: never."""
    bow = RIBS[1] * (np.sqrt(np.clip(1 - (z / np.float32(RIBS[2])) ** 2, 0, 1)) - 1)
    return (np.float32(build.kyphosis) * bow).astype(np.float32)


def along_spine(solid: Solid, build: Build) -> Solid:
    """A solid bent with the spine."""

    def distance(points: Points) -> np.ndarray:
        x, y, z = points
        return solid.distance((x, y - spine_shift(z, build), z))

    return Solid(distance, (solid.low[0], solid.low[1] - RIBS[1], solid.low[2]), solid.high)


def heart(build: Build) -> Solid:
    """The heart; its tip points left, forward and down."""
    left = _heart_part((28, -28, -45), (48, 42, 52), build)
    return join([left, _heart_part((-2, -18, -30), (42, 40, 50), build)])


def _heart_part(centre: Triple, radii: Triple, build: Build) -> Solid:
    x, y, z = centre
    return ellipsoid(
        (x + build.heart_left_mm, y, z),
        (radii[0] * build.heart, radii[1] * build.heart, radii[2] * build.heart),
    )


def great_vessels() -> list[Solid]:
    """Aorta, pulmonary trunk and arteries, and the upper caval vein."""
    aorta = [(8, -22, -5), (-6, -26, 40), (2, -10, 72), (16, 18, 76), (23, 42, 58), (22, 46, -150)]
    trunk = [(22, -36, 0), (16, -22, 26), (0, -4, 28)]
    return [
        *tube(np.array(aorta, float), 12.5),
        *tube(np.array(trunk, float), 13.0),
        *tube(np.array([(-34, 0, 22), (2, -8, 28), (34, 6, 30)], float), 10.0),
        *tube(np.array([(-24, -22, 130), (-24, -20, 20)], float), 8.5),
    ]


def mediastinum(build: Build) -> list[Solid]:
    """All between the lungs that keeps them apart: they lie beside it."""
    column = ellipsoid((0, VERTEBRAL_Y + 8, 0), (28, 38, 900))
    return [
        heart(build),
        *great_vessels(),
        ellipsoid((0, 8, 40), (27, 52, 300)),  # trachea, gullet, and the fat around them
        ellipsoid((0, 0, 0), (7, 160, 400)),  # where the lungs nearly touch in front
        along_spine(column, build),
    ]


def paint_mediastinum(canvas: Canvas, build: Build) -> None:
    """Heart, great vessels and gullet, in the fat that `paint_trunk` left."""
    paint(canvas, [heart(build)], BLOOD, BODY)
    paint(canvas, great_vessels(), BLOOD, BODY)
    gullet = np.array([(3, 26, 150), (3, 26, 40), (10, 30, -150)], float)
    paint(canvas, tube(gullet, 7.0, 1.0), SOFT, BODY)
