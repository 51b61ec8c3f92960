"""Endoscopic frames as a folder of pictures."""

from collections import Counter
from collections.abc import Mapping
from io import BytesIO
from pathlib import PurePath

import numpy as np
from jaxtyping import UInt8

from nodes.errors import BadInput
from nodes.reconstruction.artefacts import Frames

_PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")


class FramesFormat:
    """`frame_0000.png` and on, lossless; reads PNG, JPEG, BMP, TIFF and WebP of any name.

    Pictures of another suffix than most in the folder, such as a mask, are left out and counted.
    Only pixels are read: what a camera notes beside them (time, place, owner) stays in the file.
    """

    @staticmethod
    def encode(value: Frames) -> dict[str, bytes]:
        """Return one PNG for each frame."""
        return {f"frame_{n:04d}.png": _write_png(pixels) for n, pixels in enumerate(value.pixels)}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> Frames:
        """Return the frames of a folder.

        Raises
        ------
        BadInput : if there is no picture, one cannot be read, or their sizes differ.
        """
        pictures = sorted(name for name in files if name.lower().endswith(_PICTURES))
        suffixes = Counter(PurePath(name).suffix.lower() for name in pictures)
        names = [n for n in pictures if n.lower().endswith(suffixes.most_common(1)[0][0])]
        if not names:
            raise BadInput(
                f"{len(files)} files, none of them a picture",
                f"frames must be {', '.join(_PICTURES)}",
                "name the folder that holds the pictures; export a video's frames first",
            )
        frames = [_read_picture(files[name], n + 1, len(names)) for n, name in enumerate(names)]
        sizes = {frame.shape[:2] for frame in frames}
        if len(sizes) > 1:
            raise BadInput(
                f"frames of {len(sizes)} sizes",
                "all frames of a case must come from one camera and have one size",
                "put each camera's frames into a folder of their own",
            )
        return Frames(np.stack(frames), len(pictures) - len(names))


def _write_png(pixels: UInt8[np.ndarray, "rows columns 3"]) -> bytes:
    from PIL import Image

    buffer = BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG", compress_level=1)
    return buffer.getvalue()


def _read_picture(data: bytes, number: int, count: int) -> UInt8[np.ndarray, "rows columns 3"]:
    from PIL import Image

    try:
        return np.asarray(Image.open(BytesIO(data)).convert("RGB"))
    except (OSError, SyntaxError, ValueError) as error:
        raise BadInput(  # a file's name may be a patient's, so it is told by its number
            f"picture {number} of {count} cannot be read",
            "every frame must be a whole picture",
            "take the broken file out of the folder, or copy it again",
        ) from error
