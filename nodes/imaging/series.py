"""Which of the planes in a person's files belong together, and which of the stacks is wanted."""

from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.imaging.artefacts import Slice
from nodes.imaging.parameters import ReadVolumeParameters


@dataclass(frozen=True)
class Series:
    """Planes that may be one stack, and their number in the list that people see."""

    number: int
    planes: tuple[Slice, ...]

    @property
    def size(self) -> int:
        """Number of voxels."""
        return sum(plane.pixels.size for plane in self.planes)

    def may_be_volume(self, fewest_planes: int) -> bool:
        """Return whether it is more than an overview or a few single pictures."""
        return len(self.planes) >= fewest_planes and "localizer" not in self.planes[0].kind

    def describe(self) -> str:
        """Return number, modality, planes, size, spacing and kind, without any identifier."""
        first = self.planes[0]
        rows, columns = first.pixels.shape
        width, height = np.linalg.norm(first.patient_from_pixel[:3, :2], axis=0)
        parts = [
            f"{self.number}: {first.modality}",
            f"{len(self.planes)} planes of {columns} x {rows}",
            f"{width:.2f} x {height:.2f} mm",
        ]
        if len(self.planes) > 1:
            step = np.median(np.diff(np.sort(plane_heights(self.planes))))
            parts.append(f"{step:.2f} mm apart")
        return ", ".join([*parts, first.kind] if first.kind else parts)


def plane_heights(planes: Iterable[Slice]) -> Float[np.ndarray, "n"]:
    """Return the places of the planes along the normal of the first, mm."""
    matrices = np.stack([plane.patient_from_pixel for plane in planes])
    return matrices[:, :3, 3] @ matrices[0, :3, 2]


def split_series(slices: tuple[Slice, ...], parameters: ReadVolumeParameters) -> list[Series]:
    """Return the stacks among the planes, in the order in which their first planes appear.

    What has one series UID may still be several stacks: overview images, other directions or
    sizes are told apart for certain. Planes at one place are told apart by kind (echo, b-value,
    moment, ...) or else by acquisition, if that leaves stacks without doubled planes.
    """
    stacks: list[list[Slice]] = []
    for planes in _grouped(slices, lambda plane: (plane.series, plane.modality)):
        for alike in _grouped(planes, _sizes):
            for stack in _split_by_direction(alike, parameters.orientation_tolerance_deg):
                stacks += _split_doubled(stack, parameters)
    return [Series(number, tuple(planes)) for number, planes in enumerate(stacks, start=1)]


def _grouped(planes: Iterable[Slice], key: Callable[[Slice], Hashable]) -> Iterable[list[Slice]]:
    groups: dict[Hashable, list[Slice]] = {}
    for plane in planes:
        groups.setdefault(key(plane), []).append(plane)
    return groups.values()


def _sizes(plane: Slice) -> Hashable:
    """Return what differs for certain between overview and stack, or stack and stack."""
    spacing_um = np.rint(1000 * np.linalg.norm(plane.patient_from_pixel[:3, :2], axis=0))
    return "localizer" in plane.kind, plane.pixels.shape, tuple(spacing_um)


def _split_by_direction(planes: list[Slice], tolerance_deg: float) -> list[list[Slice]]:
    groups: list[list[Slice]] = []
    for plane in planes:
        for group in groups:
            if _turn_deg(group[0], plane) <= tolerance_deg:
                group.append(plane)
                break
        else:
            groups.append([plane])
    return groups


def _turn_deg(one: Slice, other: Slice) -> float:
    """Return the largest angle between the same axis of two planes, degrees."""
    a, b = one.patient_from_pixel[:3, :3], other.patient_from_pixel[:3, :3]
    lengths = np.linalg.norm(a, axis=0) * np.linalg.norm(b, axis=0)
    return float(np.rad2deg(np.arccos(np.clip(np.sum(a * b, axis=0) / lengths, -1, 1))).max())


def _split_doubled(planes: list[Slice], parameters: ReadVolumeParameters) -> list[list[Slice]]:
    """Return stacks without two planes at one place; where no mark gives them, all as they are."""

    def is_stack(group: list[Slice]) -> bool:
        steps = np.diff(np.sort(plane_heights(group)))
        return len(group) >= parameters.fewest_planes and bool(
            steps.min() > parameters.position_tolerance_mm
        )

    if len(planes) < parameters.fewest_planes or is_stack(planes):
        return [planes]
    marks: tuple[Callable[[Slice], Hashable], ...] = (
        lambda plane: plane.kind,
        lambda plane: plane.acquisition,
        lambda plane: (plane.kind, plane.acquisition),
    )
    for mark in marks:
        groups = list(_grouped(planes, mark))
        if all(is_stack(group) for group in groups):
            return groups
    return [planes]


def choose_series(
    series: list[Series], parameters: ReadVolumeParameters
) -> tuple[tuple[Slice, ...], tuple[str, ...]]:
    """Return the planes of the wanted series, and a notice if there was a choice.

    Raises
    ------
    BadInput where none is of the modality or as named, or where none is clearly the largest.
    """
    named = _named_series(series, parameters)
    stacks = [one for one in named if one.may_be_volume(parameters.fewest_planes)] or named
    largest = max(stacks, key=lambda one: one.size)
    rivals = [one for one in stacks if one.size > parameters.rival_share * largest.size]
    if len(rivals) > 1:
        share = parameters.rival_share
        rule = f"one is clearly the largest: no other has more than {share:g} of its voxels"
        raise _unclear(named, f"{len(named)} series and no clear choice", rule)
    if len(series) == 1:
        return largest.planes, ()
    why = "as asked" if parameters.series else "the largest"
    notice = f"series {largest.number} of {len(series)} was chosen, {why} ({len(largest.planes)}"
    return largest.planes, (f"{notice} planes)",)


def _named_series(series: list[Series], parameters: ReadVolumeParameters) -> list[Series]:
    """Return those of the wanted modality that the person named; all where nothing is named."""
    wanted = [one for one in series if parameters.modality in (one.planes[0].modality, "any")]
    if not wanted:
        found = ", ".join(sorted({one.planes[0].modality for one in series})) or "none"
        raise BadInput(
            f"modalities found: {found}",
            f"a series of modality {parameters.modality} is wanted",
            "set the parameter modality to what there is, or name the folder with the series",
        )
    named = [one for one in wanted if _is_named(one, parameters.series)]
    if not named:
        raise _unclear(wanted, "no series is named so", "the parameter series names one of these")
    return named


def _is_named(series: Series, name: str) -> bool:
    return name in ("", str(series.number), series.planes[0].series_key)


def _unclear(series: list[Series], value: str, rule: str) -> BadInput:
    listing = "".join(f"\n    {one.describe()}" for one in series)
    return BadInput(
        f"{value}:{listing}",
        rule,
        "set the parameter series to a number of this list or to a series instance UID,"
        " or name the folder that holds one series",
    )
