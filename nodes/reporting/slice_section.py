"""The fragment of a page in which the slice viewer stands."""

from nodes.reporting.embedding import embed_json
from nodes.reporting.parameters import ShowVolumeParameters
from nodes.reporting.rendering import render_template
from nodes.reporting.slice_data import SliceData

SCRIPTS = ("slice_voxels", "slice_pane", "slices")
"""What the viewer needs, in the order in which the page runs them."""


def render_slices(data: SliceData, parameters: ShowVolumeParameters) -> str:
    """Return the HTML of one slice viewer with its data."""
    block = data.header["block"]
    values = {
        "title": parameters.title,
        "caption": parameters.caption,
        "tilt_deg": data.tilt_deg,
        "block": " x ".join(map(str, block)) if max(block) > 1 else "",
        "plain": data.header["plain"],
        "header": embed_json(data.header),
        "grey": data.grey,
        "labels": data.labels,
    }
    return render_template("slices.html", values)
