"""Endoscopic frames as a strip."""

from jaxtyping import UInt8
from numpy import ndarray

from nodes.reconstruction.artefacts import Frames
from nodes.reporting.artefacts import Section
from nodes.reporting.embedding import embed_picture
from nodes.reporting.parameters import ShowFramesParameters
from nodes.reporting.rendering import render_template


def show_frames(frames: Frames, parameters: ShowFramesParameters) -> Section:
    """Show endoscopic frames as a strip to scroll through.

    Parameters
    ----------
    frames : all frames of one camera.
    parameters : title, how many frames at most, their width and quality.
    """
    count = len(frames.pixels)
    step = -(-count // parameters.most_frames)
    pictures = [
        {"number": n + 1, "source": _embed(frames.pixels[n], parameters)}
        for n in range(0, count, step)
    ]
    rows, columns = frames.pixels.shape[1:3]
    size = f"{count} frames of {columns} x {rows} pixels"
    values = {"pictures": pictures, "count": count, "size": size, "step": step}
    return Section(parameters.title, render_template("frames.html", values))


def _embed(pixels: UInt8[ndarray, "rows columns 3"], parameters: ShowFramesParameters) -> str:
    from PIL import Image

    picture = Image.fromarray(pixels)
    picture.thumbnail((parameters.width, parameters.width))
    return embed_picture(picture, parameters.quality)
