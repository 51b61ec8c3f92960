"""Frames: pixels come back, and nothing else of a picture does."""

from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from catalog.formats.frames import FramesFormat
from nodes.errors import BadInput
from nodes.reconstruction.artefacts import Frames


def some_frames(count: int = 3, rows: int = 4, columns: int = 6) -> Frames:
    chance = np.random.default_rng(1)
    return Frames(chance.integers(0, 256, (count, rows, columns, 3), dtype=np.uint8))


def picture(kind: str, size: tuple[int, int] = (6, 4), **more: object) -> bytes:
    buffer = BytesIO()
    Image.new("RGB", size, (10, 200, 30)).save(buffer, kind, **more)
    return buffer.getvalue()


def test_pixels_come_back_in_order() -> None:
    frames = some_frames(12)
    again = FramesFormat.decode(FramesFormat.encode(frames))
    np.testing.assert_array_equal(again.pixels, frames.pixels)
    assert again.skipped == 0


def test_what_is_written_opens_elsewhere(tmp_path: Path) -> None:
    import SimpleITK as sitk

    frames = some_frames(1)
    (data,) = FramesFormat.encode(frames).values()
    (tmp_path / "frame.png").write_bytes(data)
    read = sitk.GetArrayFromImage(sitk.ReadImage(tmp_path / "frame.png"))
    np.testing.assert_array_equal(read, frames.pixels[0])


def test_names_give_the_order_and_other_files_do_not_count() -> None:
    red, blue = picture("PNG"), some_frames(1)
    (data,) = FramesFormat.encode(blue).values()
    files = {"b.png": red, "a.png": data, "notes.txt": b"x", "mask.bmp": picture("BMP")}
    frames = FramesFormat.decode(files)
    np.testing.assert_array_equal(frames.pixels[0], blue.pixels[0])
    assert (len(frames.pixels), frames.skipped) == (2, 1)


def test_exif_stays_in_the_file() -> None:
    exif = Image.Exif()
    exif[0x013B] = "Doe^Jane"  # artist
    frames = FramesFormat.decode({"a.jpg": picture("JPEG", exif=exif)})
    assert all(b"Doe" not in data for data in FramesFormat.encode(frames).values())


(WHOLE,) = FramesFormat.encode(some_frames(1, 50, 50)).values()
HALF = WHOLE[: len(WHOLE) // 2]


@pytest.mark.parametrize(
    ("files", "told"),
    [
        ({"a.txt": b"x"}, "none of them a picture"),
        ({"Doe.png": b"no picture", "b.png": picture("PNG")}, "picture 1 of 2 cannot be read"),
        ({"a.png": HALF}, "picture 1 of 1 cannot be read"),
        ({"a.png": picture("PNG"), "b.png": picture("PNG", (5, 4))}, "2 sizes"),
    ],
)
def test_what_is_no_set_of_frames_is_refused_without_names(files: dict, told: str) -> None:
    with pytest.raises(BadInput, match=told) as refusal:
        FramesFormat.decode(files)
    assert "Doe" not in str(refusal.value)
