"""Volumes as NRRD: patient axes in the header, opens in 3D Slicer, ITK-SNAP and ParaView."""

from collections.abc import Mapping

from catalog.formats.header_text import origin_from_text, origin_to_text
from catalog.formats.nrrd_file import read_nrrd, write_nrrd
from nodes.geometry.grids import Volume


class VolumeFormat:
    """`volume.nrrd`, axes left-posterior-superior in mm, lossless."""

    @staticmethod
    def encode(value: Volume) -> dict[str, bytes]:
        """Return the one file of a volume."""
        entries = {"tendril_unit": value.unit, "tendril_origin": origin_to_text(value.origin)}
        return {"volume.nrrd": write_nrrd(value.voxels, value.patient_from_index, entries)}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> Volume:
        """Return the volume of `encode`, equal in every field."""
        voxels, patient_from_index, entries = read_nrrd(files["volume.nrrd"])
        origin = origin_from_text(entries["tendril_origin"])
        return Volume(voxels, patient_from_index, entries["tendril_unit"], origin)
