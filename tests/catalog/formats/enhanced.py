"""Enhanced multi-frame DICOM files, made from planes by hand (DICOM PS3.3 A.36 and A.38)."""

from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import SimpleITK as sitk
from pydicom import Dataset, dcmread
from pydicom.dataset import FileMetaDataset
from pydicom.encaps import encapsulate, generate_frames
from pydicom.sequence import Sequence
from pydicom.uid import (
    EnhancedCTImageStorage,
    EnhancedMRImageStorage,
    ExplicitVRLittleEndian,
    RLELossless,
)
from scipy.spatial.transform import Rotation

from catalog.formats.image_files import ImageFilesFormat
from nodes.imaging.artefacts import Slice


def planes(count=4, shape=(5, 7), seed=0, modality="CT", step=2.5):
    """Planes of an oblique stack with random values."""
    chance = np.random.default_rng(seed)
    axes = Rotation.random(rng=chance).as_matrix()
    made = []
    for number in range(count):
        matrix = np.eye(4)
        matrix[:3, :3] = axes * [0.7, 0.9, 1.0]
        matrix[:3, 3] = axes[:, 2] * step * number + [1, 2, 3]
        pixels = chance.integers(-1024, 3000, shape).astype(np.int16)
        made.append(Slice(pixels, matrix, 1, modality, "intensity"))
    return made


def decode(content: bytes) -> tuple[Slice, ...]:
    """The planes of one file, in a folder of its own."""
    return ImageFilesFormat.decode({"enhanced": content}).slices


def group(**sequences):
    """One functional group: name of a sequence -> what its one item says."""
    dataset = Dataset()
    for name, items in sequences.items():
        item = Dataset()
        for keyword, value in items.items():
            setattr(item, keyword, value)
        setattr(dataset, name, Sequence([item]))
    return dataset


def place_of(plane: Slice) -> dict:
    columns = plane.patient_from_pixel[:3].T
    across, down = np.linalg.norm(columns[:2], axis=1)
    orientation = [*(columns[0] / across), *(columns[1] / down)]
    return {
        "PlanePositionSequence": {"ImagePositionPatient": [f"{x:.10g}" for x in columns[3]]},
        "PlaneOrientationSequence": {"ImageOrientationPatient": [f"{x:.10g}" for x in orientation]},
        "PixelMeasuresSequence": {"PixelSpacing": [f"{down:.10g}", f"{across:.10g}"]},
    }


def enhanced_file(planes, per_frame=(), shared=None, share=(), packed="", **top) -> bytes:
    """Write all planes as one file.

    Parameters
    ----------
    per_frame : for each frame, further functional groups.
    shared : further functional groups of all.
    top : what the file says at its top instead, also of what it lacks.
    share : names of those place sequences that are written once for all frames.
    packed : how each frame is compressed, see `pack`.
    """
    places = [place_of(plane) for plane in planes]
    further = list(per_frame) or [{} for _ in planes]
    dataset = Dataset()
    modality = planes[0].modality
    dataset.SOPClassUID = EnhancedMRImageStorage if modality == "MR" else EnhancedCTImageStorage
    dataset.SOPInstanceUID, dataset.SeriesInstanceUID = "2.25.7", "2.25.8"
    dataset.PatientName, dataset.Modality = "SECRET^NAME", modality
    dataset.ImageType = ["ORIGINAL", "PRIMARY", "VOLUME", "NONE"]
    dataset.NumberOfFrames = len(planes)
    dataset.Rows, dataset.Columns = planes[0].pixels.shape
    dataset.SamplesPerPixel, dataset.PhotometricInterpretation = 1, "MONOCHROME2"
    dataset.BitsAllocated = dataset.BitsStored = 16
    dataset.HighBit, dataset.PixelRepresentation = 15, 1
    common = {name: places[0][name] for name in share}
    dataset.SharedFunctionalGroupsSequence = Sequence([group(**common, **(shared or {}))])
    dataset.PerFrameFunctionalGroupsSequence = Sequence(
        [
            group(**{name: value for name, value in place.items() if name not in share}, **more)
            for place, more in zip(places, further, strict=True)
        ]
    )
    dataset.file_meta = FileMetaDataset()
    dataset.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    frames = [plane.pixels.astype("<i2").tobytes() for plane in planes]
    dataset.PixelData = b"".join(frames)
    pack(dataset, packed)
    for keyword, value in top.items():
        setattr(dataset, keyword, value)
    file = BytesIO()
    dataset.save_as(file, enforce_file_format=True)
    return file.getvalue()


def pack(dataset: Dataset, packed: str) -> None:
    """Compress each frame: "rle" by pydicom, "JPEG" and "JPEG2000" (both lossless) by ITK."""
    if packed == "rle":
        dataset.compress(RLELossless, generate_instance_uid=False)
    elif packed:
        frames = [itk_frame(frame, packed) for frame in dataset.pixel_array.reshape(
            -1, dataset.Rows, dataset.Columns)]  # fmt: skip
        dataset.PixelData = encapsulate([next(generate_frames(f.PixelData)) for f in frames])
        dataset["PixelData"].is_undefined_length = True
        dataset.file_meta.TransferSyntaxUID = frames[0].file_meta.TransferSyntaxUID


def itk_frame(values: np.ndarray, kind: str) -> Dataset:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.dcm"
        writer = sitk.ImageFileWriter()
        writer.SetFileName(str(path))
        writer.SetUseCompression(True)
        writer.SetCompressor(kind)
        writer.Execute(sitk.GetImageFromArray(values[None]))
        return dcmread(path)
