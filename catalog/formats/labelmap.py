"""Label maps as segmentation NRRD, whose names and colours 3D Slicer shows."""

import colorsys
from collections.abc import Mapping

from catalog.formats.header_text import from_ascii, origin_from_text, origin_to_text, to_ascii
from catalog.formats.nrrd_file import read_nrrd, write_nrrd
from nodes.geometry.grids import LabelMap

# A turn by the golden ratio keeps the hues of neighbouring labels far apart.
_HUE_STEP = 0.618034


class LabelMapFormat:
    """`labels.seg.nrrd`; segment n carries label n + 1, its name and a colour of its own."""

    @staticmethod
    def encode(value: LabelMap) -> dict[str, bytes]:
        """Return the one file of a label map."""
        entries = {"tendril_origin": origin_to_text(value.origin)}
        for n, name in enumerate(value.names):
            color = colorsys.hsv_to_rgb(n * _HUE_STEP % 1, 0.55, 0.9)
            entries |= {
                f"Segment{n}_ID": to_ascii(name),
                f"Segment{n}_Name": to_ascii(name),
                f"Segment{n}_LabelValue": str(n + 1),
                f"Segment{n}_Layer": "0",
                f"Segment{n}_Color": " ".join(f"{c:.3f}" for c in color),
            }
        return {"labels.seg.nrrd": write_nrrd(value.voxels, value.patient_from_index, entries)}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> LabelMap:
        """Return the label map of `encode`, equal in every field."""
        voxels, patient_from_index, entries = read_nrrd(files["labels.seg.nrrd"])
        count = sum(key.endswith("_LabelValue") for key in entries)
        names = tuple(from_ascii(entries[f"Segment{n}_Name"]) for n in range(count))
        origin = origin_from_text(entries["tendril_origin"])
        return LabelMap(voxels, patient_from_index, names, origin)
