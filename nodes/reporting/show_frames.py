"""Endoscopic frames as a strip."""

import numpy as np
from jaxtyping import UInt8

from nodes.reconstruction.artefacts import Frames
from nodes.reporting.artefacts import Section
from nodes.reporting.embedding import encode_base64
from nodes.reporting.mosaics import encode_webp
from nodes.reporting.parameters import ShowFramesParameters
from nodes.reporting.rendering import render_template


def show_frames(frames: Frames, parameters: ShowFramesParameters) -> Section:
    """Show endoscopic frames as a strip to scroll through.

    Parameters
    ----------
    frames : all frames of one camera.
    parameters : title, how many frames at most, their width and quality.
    """
    count, rows, columns, _ = frames.pixels.shape
    step = -(-count // parameters.most_frames)
    pictures = [
        {"number": n + 1, "source": _embed(frames.pixels[n], parameters)}
        for n in range(0, count, step)
    ]
    size = f"{count} frames of {columns} x {rows} pixels"
    values = {"pictures": pictures, "count": count, "size": size, "step": step}
    left_out = f"{frames.skipped} pictures of another kind were left out"
    warnings = (left_out,) if frames.skipped else ()
    return Section(parameters.title, render_template("frames.html", values), warnings)


def _embed(pixels: UInt8[np.ndarray, "rows columns 3"], parameters: ShowFramesParameters) -> str:
    from PIL import Image

    picture = Image.fromarray(pixels)
    picture.thumbnail((parameters.width, parameters.width))
    small = encode_webp(np.asarray(picture), parameters.quality)
    return f"data:image/webp;base64,{encode_base64(small)}"
