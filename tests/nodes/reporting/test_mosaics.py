from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from nodes.reporting.mosaics import encode_png, encode_webp, lay_mosaic

RANDOM = np.random.default_rng(3)


@pytest.mark.parametrize("shape", [(5, 7, 1), (20, 16, 10), (33, 3, 17)])
def test_each_slice_stands_upright_in_its_tile(shape):
    voxels = RANDOM.integers(0, 256, shape).astype(np.uint8)
    picture, tiles = lay_mosaic(voxels)
    for k in range(shape[2]):
        x = (k % tiles["columns"]) * tiles["width"]
        y = (k // tiles["columns"]) * tiles["height"]
        assert np.array_equal(picture[y : y + shape[1], x : x + shape[0]], voxels[:, :, k].T)


def test_png_is_exact():
    picture = RANDOM.integers(0, 256, (40, 30)).astype(np.uint8)
    assert np.array_equal(np.array(Image.open(BytesIO(encode_png(picture)))), picture)


def test_webp_stays_near_a_smooth_picture():
    picture = np.add.outer(np.arange(128), np.arange(120)).astype(np.uint8)
    read = np.array(Image.open(BytesIO(encode_webp(picture, 80))).convert("L"), int)
    assert np.sqrt(np.mean((read - picture) ** 2)) < 3
