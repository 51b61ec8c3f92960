"""Label maps as people have them: a folder of masks, one file with many numbers, or segmentations.

A label is called by its segment (3D Slicer's .seg.nrrd and our own), a mask that is alone in its
file by the file's name without its ending, and one of several numbers in a file by that and the
number ("organs_5"). So these names, and no others, pass on to all that is made from them: no file
or segment may be called by a patient's name.
"""

import json
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np
from jaxtyping import Float, Shaped

from catalog.formats import itk_files, segments_file
from catalog.formats.labelmap import LabelMapFormat
from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap
from nodes.geometry.label_files import FileLabels, LabelFiles
from nodes.geometry.masks import bounding_box
from nodes.geometry.origin import Origin

MOST_LABELS = 255  # of 8 bits
_LIST = "label_files.json"
_FILE = "labels.seg.nrrd"


@dataclass(frozen=True)
class _Layer:
    """Numbers on a grid, the names that the file gives them, and the name of the file itself."""

    numbers: Shaped[np.ndarray, "i j k"]
    patient_from_index: Float[np.ndarray, "4 4"]
    names: Mapping[int, str]
    stem: str
    origin: Origin


class LabelFilesFormat:
    """Any files in any nesting: NIfTI, NRRD, MetaImage, .seg.nrrd; others are counted only."""

    @staticmethod
    def encode(value: LabelFiles) -> dict[str, bytes]:
        """Write one .seg.nrrd file a map, and a list that keeps how each lay in its grid."""
        grids = [{"corner": each.corner, "grid_shape": each.grid_shape} for each in value.maps]
        listed = json.dumps({"skipped": value.skipped, "grids": grids}, indent=1)
        files = {
            f"{number:04}.seg.nrrd": LabelMapFormat.encode(each.content)[_FILE]
            for number, each in enumerate(value.maps, start=1)
        }
        return {_LIST: listed.encode(), **files}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> LabelFiles:
        """Read all label maps; no file at all means that nothing is handed in.

        Raises
        ------
        BadInput where there are files but none is a label map, for a file that cannot be read,
        holds something else or is empty, and for two labels of one name.
        """
        if _LIST in files:
            return _decode_own(files)
        names = [name for name in sorted(files) if _is_label_map_name(name)]
        if files and not names:
            raise _nothing_to_read(len(files))
        used = {name for each in names for name in _used_files(each, files)}
        maps = tuple(layer for name in names for layer in _read_file(name, files))
        _refuse_equal_names(maps)
        return LabelFiles(maps, len(files) - len(used))


def _decode_own(files: Mapping[str, bytes]) -> LabelFiles:
    listed = json.loads(files[_LIST])
    maps = (
        FileLabels(
            LabelMapFormat.decode({_FILE: files[f"{number:04}.seg.nrrd"]}),
            corner=tuple(grid["corner"]),
            grid_shape=tuple(grid["grid_shape"]),
        )
        for number, grid in enumerate(listed["grids"], start=1)
    )
    return LabelFiles(tuple(maps), listed["skipped"])


def _is_label_map_name(name: str) -> bool:
    """A name that begins with a dot belongs to a computer's housekeeping (macOS: "._mask.nii")."""
    return itk_files.is_volume_name(name) and not PurePosixPath(name).name.startswith(".")


def _used_files(name: str, files: Mapping[str, bytes]) -> set[str]:
    """Return the file itself, and the one with its pixels where that is another."""
    folder = PurePosixPath(name).parent
    return {str(folder / each) for each in itk_files.companions(name, files)}


def _read_file(name: str, files: Mapping[str, bytes]) -> Iterator[FileLabels]:
    """Yield the layers of one file; errors say by its label which file is meant."""
    stem = _stem(name)
    try:
        for layer in _layers(name, stem, files):
            yield _file_labels(layer)
    except BadInput as error:
        raise BadInput(f"{stem}: {error.value}", error.rule, error.cure) from None


def _stem(name: str) -> str:
    """Return the file's name without its folder and ending; that is how its label is called."""
    base = PurePosixPath(name).name
    suffixes = (".seg.nrrd", *itk_files.VOLUME_SUFFIXES)
    longest = max((s for s in suffixes if base.lower().endswith(s)), key=len)
    return base[: -len(longest)]


def _layers(name: str, stem: str, files: Mapping[str, bytes]) -> Iterator[_Layer]:
    if segments_file.is_segmentation(name, files[name]):
        found = segments_file.read_segmentation(files[name])
        for numbers, names in zip(found.layers, found.names, strict=True):
            yield _Layer(numbers, found.patient_from_index, names, stem, found.origin)
    else:
        volume = itk_files.read_volume(name, itk_files.companions(name, files))
        notices = tuple(f"{stem}: {notice}" for notice in volume.origin.notices)
        origin = Origin("label maps handed in", notices=notices)
        yield _Layer(volume.voxels, volume.patient_from_index, {}, stem, origin)


def _file_labels(layer: _Layer) -> FileLabels:
    _refuse_what_is_no_label_map(layer.numbers)
    box = bounding_box(layer.numbers != 0)
    numbers = layer.numbers[box]
    used = _distinct(numbers)
    _refuse_empty_or_crowded(used, layer)
    voxels = np.empty(numbers.shape, np.uint8)
    for place, plane in enumerate(numbers):  # counts of numbers up to each take 8 bytes a voxel
        voxels[place] = np.searchsorted(used, plane, side="right")
    names = tuple(_label_name(layer, int(number), len(used)) for number in used)
    corner = tuple(side.start for side in box)
    matrix = layer.patient_from_index.copy()
    matrix[:3, 3] += matrix[:3, :3] @ np.array(corner)
    return FileLabels(LabelMap(voxels, matrix, names, layer.origin), corner, layer.numbers.shape)


def _distinct(numbers: Shaped[np.ndarray, "i j k"]) -> Shaped[np.ndarray, " n"]:
    """Return all numbers above 0 that occur, in order."""
    found = [np.unique(plane) for plane in numbers]
    used = np.unique(np.concatenate(found)) if found else np.zeros(0)
    return used[used > 0]


def _label_name(layer: _Layer, number: int, count: int) -> str:
    stem = layer.stem or "label"
    return layer.names.get(number) or (stem if count == 1 else f"{stem}_{number}")


def _refuse_what_is_no_label_map(numbers: Shaped[np.ndarray, "i j k"]) -> None:
    """Refuse images and probability maps, naming the first value that shows what they are."""
    for plane in numbers:
        odd = plane[(plane < 0) | (plane != np.rint(plane)) | ~np.isfinite(plane)]
        if odd.size:
            raise BadInput(
                f"the value {odd[0]:.4g}",
                "a label map holds 0 for nothing and a whole number above 0 for each label",
                "choose the label map and not the image; cut a probability map off, say at 0.5",
            )


def _refuse_empty_or_crowded(used: Shaped[np.ndarray, " n"], layer: _Layer) -> None:
    if len(used) > MOST_LABELS:
        raise BadInput(
            f"{len(used)} different numbers, up to {used[-1]:g}",
            f"a label map holds at most {MOST_LABELS} labels",
            "choose the label map and not the image, or keep only the labels that are needed",
        )
    missing = [name for number, name in layer.names.items() if number not in used]
    if missing or not len(used):
        what = f"label {missing[0]} has 0 voxels" if missing else "0 voxels"
        raise BadInput(
            what, "a label has voxels", "draw it, or take the file or the segment out of the input"
        )


def _refuse_equal_names(maps: tuple[FileLabels, ...]) -> None:
    counts = Counter(name for each in maps for name in each.content.names)
    name, count = counts.most_common(1)[0] if counts else ("", 0)
    if count > 1:
        raise BadInput(
            f"{count} labels are called {name}",
            "each label has a name of its own",
            "rename the files or segments: left_kidney.nii.gz, right_kidney.nii.gz",
        )


def _nothing_to_read(count: int) -> BadInput:
    return BadInput(
        f"{count} files, none a label map",
        f"label maps are {', '.join(itk_files.VOLUME_SUFFIXES)} files",
        "name the folder that holds them, or convert them to NIfTI",
    )
