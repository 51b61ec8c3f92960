"""What branches in the phantom's lungs: airways and vessels. Sizes in mm, as in `thorax_anatomy`.

The air in trachea, main and lobar bronchi, down to lumens 8 mm wide, is "airway"; that in the
segmental bronchi, 4 mm wide, is there but counts as lung, as most scans show it.
"""

import numpy as np
from jaxtyping import Float

from nodes.imaging.painting import Canvas, paint
from nodes.imaging.solids import tube
from nodes.imaging.thorax_anatomy import AIR, AIRWAY, BLOOD, BODY, LEFT, RIGHT, SOFT
from nodes.imaging.thorax_lungs import CARINA, HILUM, Collapse, lung_label

Course = Float[np.ndarray, "_ 3"]

TRACHEA_TOP = (0.0, -4.0, 200.0)
TRACHEA_RADIUS, MAIN_RADII = 8.5, {LEFT: 6.0, RIGHT: 7.0}
LOBAR_RADIUS, SEGMENTAL_RADIUS = 4.0, 2.0
MAIN_WALL, LOBAR_WALL, SEGMENTAL_WALL = 1.8, 1.4, 0.9
# Steps from the hilum of the left lung to the lobes: upper, (middle or lingula,) lower.
LOBES = ((16.0, -10.0, 24.0), (26.0, -20.0, -12.0), (16.0, 24.0, -30.0))
SEGMENTS, SEGMENTAL_STEP, SEGMENTAL_SPREAD = 3, 26.0, 0.55

STEMS, VESSEL_RADII = 11, (3.0, 2.1, 1.5, 1.0)
STEM_LENGTH, VESSEL_SHRINK, VESSEL_SPREAD = 36.0, 0.85, 13.0


def paint_airway(
    canvas: Canvas, collapses: dict[int, Collapse], chance: np.random.Generator
) -> None:
    """Trachea and bronchi: first all walls, then the air in them."""
    trunk = np.array([TRACHEA_TOP, CARINA])
    wide, narrow = [(trunk, TRACHEA_RADIUS, MAIN_WALL)], []
    for side, collapse in collapses.items():
        hilum = np.array([side * HILUM[0], *HILUM[1:]])
        end = collapse.move(hilum[None])[0]
        wide.append((np.array([CARINA, hilum, end]), MAIN_RADII[side], MAIN_WALL))
        for step in LOBES:
            tip = hilum + np.array(step) * (side, 1, 1)
            course = collapse.move(np.stack([hilum, tip]))
            wide.append((course, LOBAR_RADIUS * collapse.factor, LOBAR_WALL))
            for course in _segmental(tip, tip - hilum, chance):
                radius = SEGMENTAL_RADIUS * collapse.factor
                narrow.append((collapse.move(course), radius, SEGMENTAL_WALL))
    _paint_tubes(canvas, wide, narrow)


def _segmental(
    start: Float[np.ndarray, "3"], step: Float[np.ndarray, "3"], chance: np.random.Generator
) -> list[Course]:
    onward = step / np.linalg.norm(step)
    courses = []
    for _ in range(SEGMENTS):
        turn = onward + chance.normal(size=3) * SEGMENTAL_SPREAD
        courses.append(np.stack([start, start + turn / np.linalg.norm(turn) * SEGMENTAL_STEP]))
    return courses


def _paint_tubes(
    canvas: Canvas,
    wide: list[tuple[Course, float, float]],
    narrow: list[tuple[Course, float, float]],
) -> None:
    """Paint walls and air; the walls belong to what they run in, the narrow air to the lung."""
    inside = tuple(lung_label(side) for side in (RIGHT, LEFT))
    for tubes, places in ((narrow, inside), (wide, None)):
        walls = [piece for course, radius, wall in tubes for piece in tube(course, radius + wall)]
        paint(canvas, walls, SOFT, None, places)
    air = [piece for course, radius, _ in narrow for piece in tube(course, radius)]
    paint(canvas, air, AIR, None, inside)
    air = [piece for course, radius, _ in wide for piece in tube(course, radius)]
    paint(canvas, air, AIR, AIRWAY, (BODY, *inside))


def paint_vessels(
    canvas: Canvas, side: int, collapse: Collapse, chance: np.random.Generator
) -> None:
    """Vessels that branch from the hilum outwards, as far as there is lung; they count as lung."""
    root = np.array([side * HILUM[0], *HILUM[1:]])
    pieces = []
    for stem in _stems(side, chance):
        for radius, start, end in _branches(root, stem, chance):
            course = collapse.move(np.stack([start, end]))
            pieces += tube(course, radius * collapse.factor)
    paint(canvas, pieces, BLOOD, None, (lung_label(side),))


def _stems(side: int, chance: np.random.Generator) -> list[Float[np.ndarray, "3"]]:
    """Return steps to all sides of the lung, evenly spread on a half sphere and then shaken."""
    number = np.arange(STEMS)
    outward = (number + 0.5) / STEMS
    turn = number * np.pi * (3 - np.sqrt(5))  # the golden angle
    around = np.sqrt(1 - outward**2)
    even = np.stack([outward * side, around * np.cos(turn), around * np.sin(turn) * 1.3], axis=1)
    shaken = even + chance.normal(size=even.shape) * 0.15
    return list(shaken / np.linalg.norm(shaken, axis=1, keepdims=True) * STEM_LENGTH)


def _branches(
    root: Float[np.ndarray, "3"], stem: Float[np.ndarray, "3"], chance: np.random.Generator
) -> list[tuple[float, Float[np.ndarray, "3"], Float[np.ndarray, "3"]]]:
    """Return radius, start and end of a stem and the branches of its further generations."""
    branches, tips = [(VESSEL_RADII[0], root, root + stem)], [(root + stem, stem)]
    for radius in VESSEL_RADII[1:]:
        grown = []
        for tip, step in tips:
            for _ in range(2):
                turn = VESSEL_SHRINK * step + chance.normal(size=3) * VESSEL_SPREAD
                branches.append((radius, tip, tip + turn))
                grown.append((tip + turn, turn))
        tips = grown
    return branches
