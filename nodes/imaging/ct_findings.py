"""What a CT's labels tell about themselves: leaks that are refused, what a page must say."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import UInt8

from nodes.errors import BadInput
from nodes.geometry.masks import bounding_box, shrink_mask
from nodes.imaging.ct_parameters import SegmentCtParameters
from nodes.imaging.ct_scan import CtScan, Mask

KNOWN = ("body", "bone", "left_lung", "right_lung", "airway", "effusion")
LUNGS = ("left_lung", "right_lung")


@dataclass(frozen=True)
class Findings:
    """A segmentation, along the patient's axes.

    Parameters
    ----------
    labels : number n + 1 stands for `names[n]`; `names` begins with the labels looked for.
    given : those of the names that a person has drawn; they answer for them.
    scan : the CT.
    """

    labels: UInt8[np.ndarray, "x y z"]
    names: tuple[str, ...]
    given: tuple[str, ...]
    scan: CtScan

    def mask(self, name: str) -> Mask:
        """Return where a label is."""
        return self.labels == self.names.index(name) + 1

    def volumes_ml(self) -> dict[str, float]:
        """Return the volume of each label."""
        counts = np.bincount(self.labels.ravel(), minlength=len(self.names) + 1)[1:]
        millilitres = self.scan.millilitres(1)
        return {name: float(n * millilitres) for name, n in zip(self.names, counts, strict=True)}


def refuse_misspelt(given: Iterable[str]) -> None:
    """Refuse given labels whose names are known ones but for capitals, spaces or dashes."""
    for name in given:
        plain = name.strip().lower().replace(" ", "_").replace("-", "_")
        if plain in KNOWN and name not in KNOWN:
            raise BadInput(
                f"a given label {name}",
                f"the label that is looked for is called {plain}",
                f"rename it, or write `names: {{{name}: {plain}}}` for place_labels",
            )


def refuse_findings(found: Findings, parameters: SegmentCtParameters) -> None:
    """Refuse what no anatomy is.

    Raises
    ------
    BadInput for a volume beyond anatomy, an effusion under the skin, or lungs on the wrong sides.
    """
    _refuse_barren_seeds(found, parameters)
    _refuse_volumes(found, parameters)
    _refuse_skin(found, parameters)
    _refuse_swapped_lungs(found)


def _refuse_barren_seeds(found: Findings, parameters: SegmentCtParameters) -> None:
    volumes = found.volumes_ml()
    for name, points in parameters.seeds_patient_mm.items():
        if points and name not in found.given and volumes.get(name) == 0:
            raise BadInput(
                f"no {name} grew from the {len(points)} seeds of {name}",
                f"a seed lies in the middle of {name}, in tissue unlike that around it",
                f"move or take out {name}_seeds_patient_mm",
            )


def _refuse_volumes(found: Findings, parameters: SegmentCtParameters) -> None:
    limits = {
        "left_lung": (0.0, parameters.largest_lung_ml),
        "right_lung": (0.0, parameters.largest_lung_ml),
        "airway": (parameters.smallest_airway_ml, parameters.largest_airway_ml),
        "effusion": (0.0, parameters.largest_effusion_ml),
        "bone": (0.0, parameters.largest_bone_ml),
    }
    for name, volume in found.volumes_ml().items():
        if name not in limits or name in found.given:
            continue
        low, high = limits[name]
        if volume > high:
            raise _leak(f"{name} of {volume:.0f} ml", f"no {name} is larger than {high:g} ml")
        if volume < low and not parameters.corrections:
            raise BadInput(
                f"{name} of {volume:.1f} ml",
                f"no {name} is smaller than {low:g} ml",
                f"put {name}_seeds_patient_mm into its widest part, or take {name} out of labels",
            )


def _refuse_skin(found: Findings, parameters: SegmentCtParameters) -> None:
    """Refuse an effusion that lies under the skin: between it and the pleura there are ribs."""
    if "effusion" not in found.names or "effusion" in found.given:
        return
    fluid = found.mask("effusion")
    box = bounding_box(fluid, 2 + int(parameters.skin_mm / float(found.scan.spacing.min())))
    inside = found.labels[box] > 0
    under_skin = fluid[box] & ~shrink_mask(inside, parameters.skin_mm, found.scan.spacing)
    volume = found.scan.millilitres(int(np.count_nonzero(under_skin)))
    if volume > parameters.largest_skin_effusion_ml:
        raise _leak(
            f"effusion with {volume:.1f} ml less than {parameters.skin_mm:g} mm under the skin",
            "an effusion lies within the ribs",
        )


def _leak(value: str, rule: str) -> BadInput:
    return BadInput(
        f"{value}: the region has leaked",
        rule,
        "put a barrier where it leaks, move seeds into the middle of what they stand for, or change"
        " the thresholds",
    )


def _refuse_swapped_lungs(found: Findings) -> None:
    if not set(LUNGS) <= set(found.names) or not set(LUNGS) & set(found.given):
        return
    columns = [np.count_nonzero(found.mask(name), axis=(1, 2)) for name in LUNGS]
    if not all(column.any() for column in columns):
        return
    places = np.arange(found.labels.shape[0])
    left, right = (float(places @ column / column.sum()) for column in columns)
    if left < right:
        raise BadInput(
            f"the middle of left_lung lies {(right - left) * found.scan.spacing[0]:.0f} mm to the"
            " right of right_lung's",
            "left is the patient's left, +x in LPS",
            "swap the names of the labels that were given, or mend the image's orientation",
        )


def tell_findings(found: Findings, parameters: SegmentCtParameters) -> list[str]:
    """Return all that a reader of the labels must know."""
    notices = _told_of_absence(found)
    notices += [f"{name} was given by hand" for name in found.given]
    notices += [_told_of_name(name) for name in found.given if name not in KNOWN]
    notices += _told_of_hand(parameters)
    if "airway" in found.names and "airway" not in found.given:
        notices.append("the airway ends where the bronchi get too small for the scan's voxels")
    if "left_lung" in found.names and "airway" not in found.names:
        notices.append("air in trachea and bronchi that joins the lungs is counted as lung")
    return notices + _told_of_air(found, parameters) + _told_of_metal(found, parameters)


def _told_of_absence(found: Findings) -> list[str]:
    absent = [name for name, volume in found.volumes_ml().items() if volume == 0]
    return [
        "no effusion found; layers as thin as the voxels, small pockets, and fluid in strong noise"
        " are not seen"
        if name == "effusion"
        else f"the label {name} is empty"
        for name in absent
    ]


def _told_of_name(name: str) -> str:
    return f"{name} is none of the labels that are looked for, so it stands beside them"


def _told_of_hand(parameters: SegmentCtParameters) -> list[str]:
    seeded = [name for name, points in parameters.seeds_patient_mm.items() if points]
    notices = [f"grown from seeds set by hand: {', '.join(seeded)}"] if seeded else []
    for word, made in (("barriers", parameters.barriers), ("corrections", parameters.corrections)):
        if made:
            notices.append(f"{word} made by hand: {len(made)}")
    return notices


def _told_of_air(found: Findings, parameters: SegmentCtParameters) -> list[str]:
    """Tell where lungs may be missing: air without a label, or less or more lung than usual."""
    if not set(LUNGS) <= set(found.names):
        return []
    volumes, notices = found.volumes_ml(), []
    air = (found.labels == 1) & (found.scan.hu < parameters.lung_threshold_hu)
    air_ml = found.scan.millilitres(int(np.count_nonzero(air)))
    if air_ml >= parameters.smallest_lung_ml:
        notices.append(
            f"{air_ml:.0f} ml of air in the body have no label: gas in stomach and bowel, or lung"
            " that was not found"
        )
    lungs, (low, high) = sum(volumes[name] for name in LUNGS), parameters.usual_lungs_ml
    if not low <= lungs <= high:
        notices.append(
            f"the lungs hold {lungs / 1000:.2f} l together; those of healthy adults hold"
            f" {low / 1000:g} to {high / 1000:g} l"
        )
    return notices


def _told_of_metal(found: Findings, parameters: SegmentCtParameters) -> list[str]:
    dense = (found.scan.hu >= parameters.metal_hu) & (found.labels > 0)
    metal_ml = found.scan.millilitres(int(np.count_nonzero(dense)))
    if metal_ml < parameters.smallest_metal_ml:
        return []
    return [
        f"{metal_ml:.1f} ml are as dense as metal and count as bone; streaks around them can look"
        " like bone or hide it"
    ]
