"""Label files laid on one grid: named, ordered, resampled, and what that changed told."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int, UInt8

from nodes.errors import BadInput
from nodes.geometry.grids import LabelMap, voxel_volume_mm3
from nodes.geometry.label_files import FileLabels, LabelFiles
from nodes.geometry.masks import connected_parts
from nodes.geometry.origin import Origin
from nodes.geometry.regridding import (
    Grid,
    count_outside,
    index_extent,
    regrid_mask,
    same_lattice,
)

ML_IN_MM3 = 1000.0
MOST_LABELS = 255  # of 8 bits


@dataclass(frozen=True)
class Part:
    """One label of a file, and how many ml it has there."""

    labels: FileLabels
    name: str
    volume_ml: float

    @property
    def grid(self) -> Grid:
        """Return the grid of what the file holds."""
        return Grid(self.labels.content.patient_from_index, self.labels.content.voxels.shape)

    def mask(self) -> Bool[np.ndarray, "i j k"]:
        """Return where the label is, on that grid."""
        return self.labels.content.mask(self.name)


def name_layers(
    label_files: LabelFiles, names: Mapping[str, str], smallest_voxels: int
) -> dict[str, list[Part]]:
    """Give each label of the files its own or the person's name; equal names are joined.

    Parameters
    ----------
    label_files : the files' labels.
    names : label in the files -> our name; "" leaves it out.
    smallest_voxels : labels with fewer voxels in their file are refused.

    Returns
    -------
    Our name -> what it is made of, in the order of the files.

    Raises
    ------
    BadInput for a name that no file has, for tiny labels, and for too many.
    """
    found = {name: each for each in label_files.maps for name in each.content.names}
    _refuse_unknown("names", list(names), list(found))
    layers: dict[str, list[Part]] = {}
    for name, each in found.items():
        if ours := names.get(name, name):
            part = Part(each, name, _volume_ml(each, name, smallest_voxels))
            layers.setdefault(ours, []).append(part)
    if len(layers) > MOST_LABELS:
        raise BadInput(
            f"{len(layers)} labels",
            f"a label map holds at most {MOST_LABELS}",
            'join labels under one name, or leave some out, with names: {label: ""}',
        )
    return layers


def _volume_ml(each: FileLabels, name: str, smallest_voxels: int) -> float:
    count = int(np.count_nonzero(each.content.mask(name)))
    if count < smallest_voxels:
        raise BadInput(
            f"label {name} has {count} voxels",
            f"a label has at least {smallest_voxels} voxels (smallest_voxels)",
            'correct the mask, lower smallest_voxels, or leave it out with names: {label: ""}',
        )
    return count * _voxel_ml(each.content)


def _voxel_ml(image: Grid | LabelMap) -> float:
    return voxel_volume_mm3(image.patient_from_index) / ML_IN_MM3


def _refuse_unknown(what: str, written: Sequence[str], known: Sequence[str]) -> None:
    unknown = [name for name in written if name not in known]
    if unknown:
        raise BadInput(
            f"{what}: {unknown[0]}",
            f"the labels are {', '.join(known) or 'none'}",
            f"write one of them in {what}, as it stands there",
        )


def lay_layers(
    layers: Mapping[str, Sequence[Part]],
    order: Sequence[str],
    grid: Grid,
    tolerance_voxels: float,
) -> tuple[UInt8[np.ndarray, "i j k"], tuple[str, ...]]:
    """Lay labels on a grid, one over the other.

    Parameters
    ----------
    layers : our names and what they are made of, from `name_layers`; label n + 1 is the n-th.
    order : names that lie on top of all others, the last one topmost; below them, labels with less
        volume lie on those with more.
    grid : where they go.
    tolerance_voxels : voxels this near to those of the grid are copied as they are.

    Returns
    -------
    voxels : labels.
    notices : what resampling, the grid's edge and overlaps changed, in ml.

    Raises
    ------
    BadInput for an unknown name in `order` or one that stands there twice, and for a label of which
    nothing is left.
    """
    names = list(layers)
    _check_order(order, names)
    notices: list[str] = []
    covered = np.zeros((len(names) + 1, len(names) + 1), np.int64)  # by, what
    voxels = np.zeros(grid.shape, np.uint8)
    for name in _from_below(layers, order):
        number = names.index(name) + 1
        for part in layers[name]:
            mask = part.mask()
            box, laid = regrid_mask(mask, part.grid.patient_from_index, grid, tolerance_voxels)
            notices += _part_notices(part, mask, laid, grid, tolerance_voxels)
            beneath = voxels[box]
            covered[number] += np.bincount(beneath[laid], minlength=len(covered))
            beneath[laid] = number
    return voxels, (*notices, *_cover_notices(names, covered, _voxel_ml(grid)))


def _check_order(order: Sequence[str], names: Sequence[str]) -> None:
    _refuse_unknown("order", order, names)
    if len(set(order)) < len(order):
        raise BadInput(f"order: {', '.join(order)}", "each name stands there once", "take one out")


def _from_below(layers: Mapping[str, Sequence[Part]], order: Sequence[str]) -> list[str]:
    """Return the names from the lowest layer to the topmost."""
    volumes = {name: sum(part.volume_ml for part in parts) for name, parts in layers.items()}
    others = sorted(layers.keys() - set(order), key=lambda name: (-volumes[name], name))
    return [*others, *order]


def _part_notices(
    part: Part,
    mask: Bool[np.ndarray, "i j k"],
    laid: Bool[np.ndarray, "a b c"],
    grid: Grid,
    tolerance_voxels: float,
) -> Iterator[str]:
    """Yield how a label's volume and parts changed; refuse it where nothing is left."""
    outside = count_outside(mask, part.grid.patient_from_index, grid)
    count = int(np.count_nonzero(laid))
    if not count:
        raise _nothing_left(part, outside, grid)
    expected_ml = part.volume_ml - outside * _voxel_ml(part.grid)
    if outside:
        yield (
            f"{part.name}: {part.volume_ml - expected_ml:.3g} of {part.volume_ml:.4g} ml lie"
            " outside of the image and are cut off"
        )
    if same_lattice(grid, part.grid, tolerance_voxels):
        return
    laid_ml = count * _voxel_ml(grid)
    change = f"{100 * (laid_ml / expected_ml - 1):+.1f} %" if expected_ml else "all at the edge"
    yield (
        f"{part.name}: brought from another grid ({part.grid}); {expected_ml:.4g} ml became"
        f" {laid_ml:.4g} ml ({change}){_broken(mask, laid)}"
    )


def _broken(mask: Bool[np.ndarray, "i j k"], laid: Bool[np.ndarray, "a b c"]) -> str:
    """Thin structures break before they vanish, and their volume may not show it."""
    before, after = (len(connected_parts(each)[1]) for each in (mask, laid))
    return f", in {after} parts instead of {before}" if after > before else ""


def _nothing_left(part: Part, outside: int, grid: Grid) -> BadInput:
    if outside:  # of what the image holds, too little for one voxel
        return BadInput(
            f"label {part.name} lies at {_extent(part.grid)} and the image at {_extent(grid)}",
            "label and image overlap, in patient coordinates (LPS, mm)",
            'hand in the label map of this image, or leave it out with names: {label: ""}',
        )
    return BadInput(
        f"label {part.name} has {part.volume_ml:.3g} ml in its file and fills no voxel of {grid}",
        "a label fills at least half of one voxel",
        'choose smaller voxels, or leave it out with names: {label: ""}',
    )


def _extent(grid: Grid) -> str:
    low, high = index_extent(np.eye(4), grid)
    return ", ".join(
        f"{axis} {a:.1f} to {b:.1f}" for axis, a, b in zip("xyz", low, high, strict=True)
    )


def _cover_notices(
    names: Sequence[str], covered: Int[np.ndarray, "n n"], voxel_ml: float
) -> Iterator[str]:
    """Yield what each label lost to those above it; refuse one that lost all."""
    for number, name in enumerate(names, start=1):
        by = covered[:, number].copy()
        by[number] = 0  # parts of one label may overlap
        above = ", ".join(sorted(names[other - 1] for other in np.flatnonzero(by)))
        if by.sum() == covered[number].sum() - covered[number, number]:
            raise BadInput(
                f"label {name} lies under {above} in all its voxels",
                "one voxel has one label, and each label is left with voxels",
                "set order so that it lies on top, or leave one of them out with names",
            )
        if above:
            yield f"{name}: {by.sum() * voxel_ml:.3g} ml lie under {above} and count as that"


def join_origins(label_files: LabelFiles, layers: Mapping[str, Sequence[Part]]) -> Origin:
    """Return where all label files come from, and what of them was renamed, joined or left out."""
    origins = [each.content.origin for each in label_files.maps]
    sources = dict.fromkeys(origin.source for origin in origins)
    joined = [f"{name}: joined from {', '.join(part.name for part in parts)}"
              for name, parts in layers.items() if len(parts) > 1]  # fmt: skip
    kept = {part.name for parts in layers.values() for part in parts}
    names = [name for each in label_files.maps for name in each.content.names]
    left_out = [f"{name}: left out" for name in names if name not in kept]
    skipped = [f"{label_files.skipped} files that are no label maps were left out"]
    return Origin(
        ", ".join(sources) or "no label maps handed in",
        any(origin.simulated for origin in origins),
        tuple(notice for origin in origins for notice in origin.notices),
    ).with_notice(*(skipped if label_files.skipped else ()), *joined, *left_out)
