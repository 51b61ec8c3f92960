"""One colour for one name, the same in slices and in 3-D.

Anatomy wears the hues that atlases use; every other name takes a hue of a palette that people
with colour-blindness tell apart [Okabe2008].
"""

from zlib import crc32

ANATOMY = {
    "body": "#d8b49c",
    "skin": "#d8b49c",
    "head": "#d8b49c",
    "bone": "#e6d8b0",
    "skull": "#e6d8b0",
    "lungs": "#6f9fd8",
    "lung": "#6f9fd8",
    "left_lung": "#6f9fd8",
    "right_lung": "#4cb8b0",
    "collapsed_lung": "#b07cc6",
    "airway": "#f0c419",
    "trachea": "#f0c419",
    "cavity": "#e58a4e",
    "pleural_cavity": "#e58a4e",
    "effusion": "#e58a4e",
    "brain": "#e59aa2",
    "ventricles": "#5aa9e6",
    "tumour": "#d1495b",
    "nodule": "#d1495b",
}
PALETTE = ("#e69f00", "#56b4e9", "#009e73", "#f0e442", "#d55e00", "#cc79a7", "#0072b2")


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


def words(name: str) -> str:
    """Return a dataset's or part's name as people read it: left_lung becomes left lung."""
    return name.replace("_", " ")
