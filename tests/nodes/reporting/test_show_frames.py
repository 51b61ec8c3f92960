"""The strip of frames: each chosen frame once, in order, small enough to send."""

import re
from base64 import b64decode
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from nodes.reconstruction.artefacts import Frames
from nodes.reporting.parameters import ShowFramesParameters
from nodes.reporting.show_frames import show_frames

PARAMETERS = ShowFramesParameters(title="Frames", most_frames=4, width=64, quality=80)


def shown(html: str) -> list[Image.Image]:
    sources = re.findall(r"data:image/webp;base64,([^\"]+)", html)
    return [Image.open(BytesIO(b64decode(source))) for source in sources]


@pytest.mark.parametrize(("count", "wanted"), [(1, 1), (4, 4), (5, 3), (9, 3), (12, 4)])
def test_no_more_than_the_most_are_shown_and_evenly(count: int, wanted: int) -> None:
    grey = np.linspace(0, 250, count).astype(np.uint8)
    pixels = np.broadcast_to(grey[:, None, None, None], (count, 90, 160, 3)).copy()
    pictures = shown(show_frames(Frames(pixels), PARAMETERS).html)
    means = [np.asarray(picture.convert("L")).mean() for picture in pictures]
    step = -(-count // 4)
    assert len(pictures) == wanted
    np.testing.assert_allclose(means, grey[::step], atol=3)
    assert all(max(picture.size) == 64 for picture in pictures)


def test_what_was_left_out_is_a_warning() -> None:
    frames = Frames(np.zeros((2, 8, 8, 3), np.uint8), skipped=1)
    assert show_frames(frames, PARAMETERS).warnings == ("1 pictures of another kind were left out",)
    assert show_frames(Frames(frames.pixels), PARAMETERS).warnings == ()
