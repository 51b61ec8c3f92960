"""Values that formats must carry unharmed: hostile text, odd grids, and what artefacts hold."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from nodes.geometry.origin import Origin

# What ends a line, a field, a key or a quoted part in one of the file formats, or names a folder.
PIECES = ['"', "'", "\n", "\r", "%", "%0A", ":=", ": ", "\\", "/", "#", " ", "\t", "é", "肺", "🫁"]
PIECES += [
    "\u2028",
    "\x00",
    "\x7f",
    "..",
    ".ply",
    "comment ",
    "end_header",
    "TextureFile x",
    "{",
    "<b>",
    "_",
    "-",
    "1",
]
TEXTS = st.lists(st.sampled_from(PIECES) | st.text("ab", max_size=2), max_size=5).map("".join)
NAMES = TEXTS.filter(bool)
ORIGINS = st.builds(Origin, TEXTS, st.booleans(), st.lists(TEXTS, max_size=3).map(tuple))

numbers = st.floats(-1e3, 1e3, allow_subnormal=False)


@st.composite
def affines(draw: st.DrawFn) -> np.ndarray:
    """Draw a turned, anisotropic and now and then mirrored grid, with numbers of 17 digits."""
    turned, _ = np.linalg.qr(
        np.eye(3) + draw(hnp.arrays(float, (3, 3), elements=st.floats(-0.2, 0.2)))
    )
    affine = np.eye(4)
    affine[:3, :3] = turned * draw(hnp.arrays(float, 3, elements=st.floats(0.1, 5)))
    affine[:3, 3] = draw(hnp.arrays(float, 3, elements=numbers))
    return affine


SHAPES = st.tuples(*[st.integers(1, 5)] * 3)
ANY_FLOAT32 = st.floats(width=32, allow_nan=True, allow_infinity=True)


def voxels(dtype: str) -> st.SearchStrategy[np.ndarray]:
    """Draw voxels that differ from each other, with extremes."""
    elements = ANY_FLOAT32 if dtype == "float32" else hnp.from_dtype(np.dtype(dtype))
    return hnp.arrays(dtype, SHAPES, elements=elements)


def points(count: int) -> st.SearchStrategy[np.ndarray]:
    """Draw finite float32 rows of three."""
    return hnp.arrays("float32", (count, 3), elements=st.floats(-1e4, 1e4, width=32))


def assert_same(a: np.ndarray, b: np.ndarray) -> None:
    """Equal type, shape and bits, but for the many kinds of NaN."""
    assert a.dtype == b.dtype
    np.testing.assert_array_equal(a, b, strict=True)
