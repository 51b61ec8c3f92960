"""Segmentations as 3D Slicer saves them: .seg.nrrd, with names and, where segments overlap, layers.

The header's keys: slicer.readthedocs.io, Developer Guide, Segmentations. Each segment's `Extent` is
a hint for viewers, and where a voxel lies follows from the header of the image alone.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np
from jaxtyping import Float, Shaped

from catalog.formats.header_text import from_ascii, origin_from_text
from nodes.errors import BadInput
from nodes.geometry.origin import Origin

# How the axes of a NRRD's space lie in LPS.
_SIGNS = {
    "left-posterior-superior": (1, 1, 1),
    "right-anterior-superior": (-1, -1, 1),
    "left-anterior-superior": (1, -1, 1),
}
_SHORT = {"lps": "left-posterior-superior", "ras": "right-anterior-superior",
          "las": "left-anterior-superior"}  # fmt: skip


@dataclass(frozen=True)
class Segmentation:
    """Layers of numbers on one grid, and for each layer the names of its numbers."""

    layers: tuple[Shaped[np.ndarray, "i j k"], ...]
    patient_from_index: Float[np.ndarray, "4 4"]
    names: tuple[dict[int, str], ...]
    origin: Origin


def is_segmentation(name: str, content: bytes) -> bool:
    """Return whether this is a NRRD file whose header names segments."""
    header = content.partition(b"\n\n")[0]
    return name.lower().endswith(".nrrd") and b"_LabelValue:=" in header


def read_segmentation(content: bytes) -> Segmentation:
    """Read all layers; raises BadInput for a file that is cut off, damaged or without a place."""
    import nrrd

    buffer = BytesIO(content)
    try:
        header = nrrd.read_header(buffer)
        numbers = nrrd.read_data(header, buffer, index_order="F")
        layers = numbers if numbers.ndim == 4 else numbers[None]
        return Segmentation(
            layers=tuple(layers),
            patient_from_index=_patient_from_index(header),
            names=tuple(_names(header, layer) for layer in range(len(layers))),
            origin=_origin(header),
        )
    except BadInput:
        raise
    except Exception:  # whatever breaks in a broken file
        raise BadInput(
            "the segmentation is cut off or damaged",
            "the file is a whole .seg.nrrd file with its data in it",
            "save it again in 3D Slicer, or copy it again",
        ) from None


def _patient_from_index(header: Mapping[str, Any]) -> Float[np.ndarray, "4 4"]:
    space = str(header.get("space", "")).lower()
    space = _SHORT.get(space, space)
    if space not in _SIGNS:
        raise BadInput(
            f"space {space or 'missing'}",
            f"the header names the patient's axes: {', '.join(_SIGNS)}",
            "save the segmentation again in 3D Slicer",
        )
    directions = np.asarray(header["space directions"], float)
    matrix = np.eye(4)
    matrix[:3, :3] = directions[-3:].T  # a layer's axis comes first and has no direction
    matrix[:3, 3] = header["space origin"]
    if not np.isfinite(matrix).all():
        raise ValueError("another axis than the first has no direction")
    return np.diag([*_SIGNS[space], 1.0]) @ matrix


def _names(header: Mapping[str, Any], layer: int) -> dict[int, str]:
    """Return the names of one layer's numbers; our own files quote what headers cannot carry."""
    names = {}
    for key in header:
        match = re.fullmatch(r"Segment(\d+)_LabelValue", key)
        if match and int(header.get(f"Segment{match[1]}_Layer", 0)) == layer:
            name = str(header.get(f"Segment{match[1]}_Name", ""))
            names[int(header[key])] = from_ascii(name) if "tendril_origin" in header else name
    return names


def _origin(header: Mapping[str, Any]) -> Origin:
    text = header.get("tendril_origin")
    return origin_from_text(text) if text else Origin("label maps handed in")
