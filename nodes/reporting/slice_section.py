"""The fragment of a page in which the slice viewer stands."""

from nodes.reporting.embedding import embed_json
from nodes.reporting.parameters import ShowVolumeParameters
from nodes.reporting.rendering import render_template
from nodes.reporting.slice_data import SliceData


def render_slices(data: SliceData, parameters: ShowVolumeParameters) -> str:
    """Return the HTML of one slice viewer with its data."""
    values = {
        "title": parameters.title,
        "caption": parameters.caption,
        "tilt_deg": data.tilt_deg,
        "header": embed_json(data.header),
        "grey": data.grey,
        "labels": data.labels,
    }
    return render_template("slices.html", values)
