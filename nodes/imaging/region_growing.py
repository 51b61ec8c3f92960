"""Regions that grow from seeds in a CT, with ITK, and the checks of seeds that a person gives."""

import numpy as np
from jaxtyping import Int, Shaped

from nodes.errors import BadInput
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import CtScan, Mask, nearest_index

Point = tuple[float, float, float]


def grow_below(
    hu: Shaped[np.ndarray, "x y z"],
    seeds: Int[np.ndarray, "n 3"],
    highest_hu: float,
) -> Mask:
    """Return all that is connected to a seed over voxels at or below a value."""
    import SimpleITK as sitk

    grown = sitk.ConnectedThreshold(
        sitk.GetImageFromArray(hu),
        [tuple(int(n) for n in seed[::-1]) for seed in seeds],
        lower=float(hu.min()),
        upper=float(highest_hu),
    )
    return sitk.GetArrayFromImage(grown).astype(bool)


def seeds_in_tissue(
    scan: CtScan,
    points_patient_mm: tuple[Point, ...],
    within_hu: tuple[float, float],
    name: str,
) -> Int[np.ndarray, "n 3"]:
    """Return the voxels of a person's seeds.

    Raises
    ------
    BadInput where a seed lies outside of the image, in the wrong tissue, or in a barrier.
    """
    points = np.array(points_patient_mm, float).reshape(-1, 3)
    seeds = nearest_index(scan.patient_from_index, points)
    for point, seed in zip(points, seeds, strict=True):
        _refuse_outside(scan, point, seed, name)
        hu = float(scan.hu[tuple(seed)])
        if not within_hu[0] <= hu <= within_hu[1]:
            raise BadInput(
                f"{name} seed {_words(point)}: {hu:g} HU there",
                f"a seed of {name} lies in {within_hu[0]:g} to {within_hu[1]:g} HU",
                "move the seed into the tissue that it stands for; patient LPS mm",
            )
        if scan.closed[tuple(seed)]:
            raise BadInput(
                f"{name} seed {_words(point)} in a barrier",
                "no region grows through a barrier, so none can begin in it",
                "move the seed or the barrier",
            )
    return seeds


def refuse_seeds_outside(scan: CtScan, body: Mask, parameters: SegmentCtParameters) -> None:
    """Refuse seeds in the image but outside of the body: on the table, in the air around."""
    for name, points in parameters.seeds_patient_mm.items():
        for point in np.array(points, float).reshape(-1, 3):
            seed = nearest_index(scan.patient_from_index, point[None])[0]
            _refuse_outside(scan, point, seed, name)
            if not body[tuple(seed)]:
                raise BadInput(
                    f"{name} seed {_words(point)} outside of the body",
                    f"a seed of {name} lies inside the skin",
                    "move the seed into the tissue that it stands for; patient LPS mm",
                )


def _refuse_outside(
    scan: CtScan, point: Shaped[np.ndarray, "3"], seed: Int[np.ndarray, "3"], name: str
) -> None:
    last = np.array(scan.hu.shape) - 1
    if (seed < 0).any() or (seed > last).any():
        ends = np.stack([np.zeros(3), last]) @ scan.patient_from_index[:3, :3].T
        low, high = np.sort(ends + scan.patient_from_index[:3, 3], axis=0)
        raise BadInput(
            f"{name} seed {_words(point)} outside of the image",
            f"the image reaches from {_words(low)} to {_words(high)}, patient LPS mm",
            "read the point off in a viewer that shows LPS mm (RAS turns the signs of x and y)",
        )


def _words(point: Shaped[np.ndarray, "3"]) -> str:
    return "[" + ", ".join(f"{value:.1f}" for value in point) + "]"
