"""Planes as DICOM files: explicit little endian, uncompressed, and the same bytes every time."""

import hashlib
from typing import TYPE_CHECKING

import numpy as np

from nodes.imaging.artefacts import Slice

if TYPE_CHECKING:
    from pydicom import Dataset

SIMULATED = "SIMULATED"  # series description of a phantom's files
# Made up, so that tests can prove that nothing of it goes further than the file.
PERSON = {
    "PatientName": "PHANTOM^THORAX",
    "PatientID": "PHANTOM-4711",
    "PatientBirthDate": "19010203",
    "PatientSex": "O",
    "StudyDate": "19991231",
    "StudyTime": "235959",
    "AccessionNumber": "ACC-4711",
    "ReferringPhysicianName": "NOBODY^AT^ALL",
    "StudyID": "STUDY-4711",
}


def write_planes(slices: tuple[Slice, ...], simulated: bool) -> dict[str, bytes]:
    """Write one file for each plane, named in the order of the planes."""
    digests = [_digest(plane) for plane in slices]
    study = _uid("study", *digests)
    names = [f"slice_{number:04d}.dcm" for number in range(1, len(slices) + 1)]
    return {
        name: _to_bytes(_dataset(plane, number, simulated, study, digest))
        for number, (name, plane, digest) in enumerate(
            zip(names, slices, digests, strict=True), start=1
        )
    }


def _digest(plane: Slice) -> str:
    content = plane.pixels.tobytes() + plane.patient_from_pixel.tobytes()
    return hashlib.sha256(content).hexdigest()


def _uid(*parts: object) -> str:
    """Return a UID made from a 128-bit number, here a hash (DICOM PS3.5 B.2)."""
    digest = hashlib.sha256(" ".join(map(str, parts)).encode()).digest()
    return f"2.25.{int.from_bytes(digest[:16], 'big')}"


def _dataset(plane: Slice, number: int, simulated: bool, study: str, digest: str) -> "Dataset":
    from pydicom import Dataset
    from pydicom.uid import CTImageStorage, MRImageStorage

    dataset = Dataset()
    dataset.update(PERSON if simulated else dict.fromkeys(PERSON, ""))
    dataset.SOPClassUID = MRImageStorage if plane.modality == "MR" else CTImageStorage
    dataset.SOPInstanceUID = _uid("plane", number, digest)
    dataset.StudyInstanceUID = study
    dataset.SeriesInstanceUID = _uid("series", study, plane.series)
    dataset.FrameOfReferenceUID = _uid("frame", study)
    dataset.ImageType = ["DERIVED", "SECONDARY", "AXIAL"]
    dataset.SeriesDescription = SIMULATED if simulated else ""
    dataset.Modality = plane.modality
    dataset.SeriesNumber, dataset.InstanceNumber = plane.series, number
    _add_geometry(dataset, plane)
    _add_pixels(dataset, plane)
    return dataset


def _add_geometry(dataset: "Dataset", plane: Slice) -> None:
    from pydicom.valuerep import format_number_as_ds

    columns = plane.patient_from_pixel[:3].T
    between_columns, between_rows = np.linalg.norm(columns[:2], axis=1)
    orientation = np.concatenate([columns[0] / between_columns, columns[1] / between_rows])

    def decimals(values: np.ndarray) -> list[str]:
        """16 characters are all that a decimal string has (DICOM PS3.5 6.2)."""
        return [format_number_as_ds(float(value)) for value in values]

    dataset.ImageOrientationPatient = decimals(orientation)
    dataset.ImagePositionPatient = decimals(columns[3])
    dataset.PixelSpacing = decimals(np.array([between_rows, between_columns]))


def _add_pixels(dataset: "Dataset", plane: Slice) -> None:
    if plane.pixels.dtype != np.int16:
        raise ValueError(f"only int16 planes can be written, these are {plane.pixels.dtype}")
    dataset.Rows, dataset.Columns = plane.pixels.shape
    dataset.SamplesPerPixel = 1
    dataset.PhotometricInterpretation = "MONOCHROME2"
    dataset.BitsAllocated = dataset.BitsStored = 16
    dataset.HighBit = 15
    dataset.PixelRepresentation = 1
    if plane.unit == "HU":
        dataset.RescaleSlope, dataset.RescaleIntercept, dataset.RescaleType = "1", "0", "HU"
    dataset.PixelData = plane.pixels.astype("<i2").tobytes()


def _to_bytes(dataset: "Dataset") -> bytes:
    from io import BytesIO

    from pydicom.dataset import FileMetaDataset
    from pydicom.uid import ExplicitVRLittleEndian

    dataset.file_meta = FileMetaDataset()
    dataset.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    dataset.file_meta.ImplementationClassUID = _uid("tendril")
    dataset.file_meta.ImplementationVersionName = "TENDRIL"
    file = BytesIO()
    dataset.save_as(file, enforce_file_format=True)
    return file.getvalue()
