"""One colour for one name, the same in slices and in 3-D.

Anatomy wears the hues that atlases and surgeons use: bone ivory, lungs pink, air cyan, fluid blue,
vessels red. Every other name takes a hue of a palette that people with colour-blindness tell apart
[Okabe2008].
"""

from zlib import crc32

import numpy as np
from jaxtyping import Float, UInt8

ANATOMY = {
    "body": "#d8b49c",
    "skin": "#d8b49c",
    "head": "#d8b49c",
    "bone": "#f1e7c9",
    "skull": "#f1e7c9",
    "lungs": "#e8909f",
    "lung": "#e8909f",
    "left_lung": "#e8909f",
    "right_lung": "#c8806a",
    "collapsed_lung": "#b0607a",
    "airway": "#27c3d9",
    "trachea": "#27c3d9",
    "cavity": "#4f86d9",
    "pleural_cavity": "#4f86d9",
    "effusion": "#4f86d9",
    "pleura": "#a5b4d8",
    "fissures": "#6fb39b",
    "adhesion": "#8e44ad",
    "vessels": "#c8232c",
    "brain": "#e59aa2",
    "left_brain": "#e59aa2",
    "right_brain": "#c79a5e",
    "ventricles": "#3f8fe0",
    "tumour": "#8cc63f",
    "nodule": "#8cc63f",
    "lesion": "#8cc63f",
    "target": "#8cc63f",
}
PALETTE = ("#e69f00", "#56b4e9", "#009e73", "#f0e442", "#d55e00", "#cc79a7", "#0072b2")
LOW_TO_HIGH = ("#d55e00", "#f0e442", "#009e73")
"""From too little to plenty: vermilion, yellow and bluish green of the same palette."""


def colour_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return a colour "#rrggbb" for each name.

    A name that is no known anatomy starts at a place of the palette that it alone decides, so that
    it keeps its colour in sections that show other parts with it.
    """
    chosen: dict[str, str] = {}
    for name in names:
        start = crc32(name.encode())
        turns = [PALETTE[(start + turn) % len(PALETTE)] for turn in range(len(PALETTE))]
        free = [colour for colour in turns if colour not in chosen.values()]
        chosen[name] = ANATOMY.get(name) or (free or turns)[0]
    return tuple(chosen[name] for name in names)


def colour_values(
    values: Float[np.ndarray, "n"], low: float, high: float
) -> UInt8[np.ndarray, "n 3"]:
    """Return red, green, blue for each value from `low` to `high`; what is not a number is grey."""
    stops = np.array([[int(c[at : at + 2], 16) for at in (1, 3, 5)] for c in LOW_TO_HIGH], float)
    shares = np.clip((values - low) / max(high - low, 1e-9), 0, 1) * (len(stops) - 1)
    places = np.arange(len(stops))
    known = np.isfinite(shares)
    colours = [np.interp(np.where(known, shares, 0), places, channel) for channel in stops.T]
    grey = np.full(3, 128.0)
    return np.rint(np.where(known[:, None], np.stack(colours, axis=1), grey)).astype(np.uint8)


def words(name: str) -> str:
    """Return a dataset's or part's name as people read it: left_lung becomes left lung."""
    return name.replace("_", " ")
