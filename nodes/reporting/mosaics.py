"""Slices side by side in one picture, which every browser decodes quickly."""

from io import BytesIO
from math import ceil, isqrt

import numpy as np
from jaxtyping import UInt8

WEBP_BLOCK = 16
"""Side of a macroblock of lossy WebP in pixels: slices that begin on one never share it (RFC 6386,
section 2)."""


def lay_mosaic(
    voxels: UInt8[np.ndarray, "i j k"],
) -> tuple[UInt8[np.ndarray, "rows columns"], dict[str, int]]:
    """Lay the slices of constant k in rows, i to the right and j down, each in a padded tile.

    Returns
    -------
    The picture, and `columns`, `width` and `height`: tiles in a row, and a tile's size in pixels.
    """
    i, j, k = voxels.shape
    width, height = (ceil(side / WEBP_BLOCK) * WEBP_BLOCK for side in (i, j))
    columns = isqrt(k - 1) + 1
    rows = ceil(k / columns)
    padded = np.pad(voxels, ((0, width - i), (0, height - j), (0, rows * columns - k)), mode="edge")
    tiles = padded.T.reshape(rows, columns, height, width)
    picture = tiles.transpose(0, 2, 1, 3).reshape(rows * height, columns * width)
    return picture, {"columns": columns, "width": width, "height": height}


def encode_webp(picture: UInt8[np.ndarray, "rows columns *colours"], quality: int) -> bytes:
    """Return a lossy WebP file."""
    from PIL import Image

    file = BytesIO()
    Image.fromarray(picture).save(file, "WEBP", quality=quality, method=4)
    return file.getvalue()


def encode_png(picture: UInt8[np.ndarray, "rows columns"]) -> bytes:
    """Return a lossless PNG file."""
    from PIL import Image

    file = BytesIO()
    Image.fromarray(picture).save(file, "PNG", compress_level=6)
    return file.getvalue()
