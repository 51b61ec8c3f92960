"""What needles and sheaths touch along a motion, in sentences and numbers."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from nodes.geometry.grids import LabelMap
from nodes.mechanics.describe_robots import name_needle
from nodes.mechanics.robots import CrispSetup
from nodes.mechanics.shapes import Figure
from nodes.planning.checking_boxes import Boxes
from nodes.planning.checking_clearances import Clearances, measure_clearances
from nodes.planning.checking_needles import measure_gaps
from nodes.planning.checking_shapes import Followed
from nodes.planning.checking_sheaths import find_bone, measure_sheath
from nodes.planning.checking_steps import FineMotion, least_at_steps, say_where
from nodes.planning.parameters import CheckCrispPlansParameters


class Space(NamedTuple):
    """The anatomy: boxes that needles must not touch, and labels that sheaths avoid."""

    cavity: Boxes
    label_map: LabelMap


class Touches(NamedTuple):
    """What was found of one motion; clearances (step,) are nan where the robot was lost before."""

    failures: list[str]
    figures: list[Figure]
    clearances_mm: Float[np.ndarray, "step"]


def check_touches(
    setup: CrispSetup,
    fine: FineMotion,
    followed: Followed,
    space: Space,
    parameters: CheckCrispPlansParameters,
) -> Touches:
    """Hold needles against anatomy and one another, and sheaths against what they avoid."""
    at = _between(fine.at[: len(followed.margins)])
    failures, figures, least = _check_anatomy(setup, followed, at, space.cavity, parameters)
    found = [_check_gaps(setup, fine, followed, parameters)]
    if parameters.sheath_avoids:
        found.append(_check_sheaths(setup, fine, followed, space.label_map, parameters))
    for broken, told in found:
        failures += broken
        figures += told
    return Touches(failures, figures, least_at_steps(least, at, fine))


def _between(at: Float[np.ndarray, "c"]) -> Float[np.ndarray, "pair"]:
    """Return where each pair of neighbouring configurations is along the motion."""
    return at if len(at) == 1 else (at[:-1] + at[1:]) / 2


def _check_anatomy(
    setup: CrispSetup,
    followed: Followed,
    at: Float[np.ndarray, "pair"],
    cavity: Boxes,
    parameters: CheckCrispPlansParameters,
) -> tuple[list[str], list[Figure], Float[np.ndarray, "pair"]]:
    failures, all_least, sheaths = [], [], []
    for needle, course in enumerate(followed.courses):
        radius = setup.needles[needle].outer_diameter_mm / 2
        found = measure_clearances(course, radius, cavity, parameters)
        all_least.append(found.least_mm)
        sheaths.append(found.sheaths_mm.max())
        failures += _say_touch(name_needle(needle), found, at, parameters)
    least = np.min(all_least, axis=0)
    asked = f"at least {parameters.margin_mm:g}"
    return failures, [
        Figure("least clearance", float(least.min()), "mm",
               "between the needles' surfaces and anatomy, a lower bound over all of the motion;"
               f" beyond the first {parameters.sheath_mm:g} mm of each needle, and what is nearer"
               f" than is asked for: {asked}"),
        Figure("longest part in a sheath", float(max(sheaths)), "mm",
               "of a needle from its entry point on, where it is not yet"
               f" {parameters.clear_mm:g} mm from the wall; at most {parameters.sheath_mm:g}"),
    ], least  # fmt: skip


def _say_touch(
    name: str,
    found: Clearances,
    at: Float[np.ndarray, "pair"],
    parameters: CheckCrispPlansParameters,
) -> list[str]:
    worst = int(np.argmin(found.least_mm))
    least = float(found.least_mm[worst])
    if least >= parameters.margin_mm:
        return []
    what = "touches anatomy" if least <= 0 else f"may come within {least:.3g} mm of anatomy"
    return [
        f"{say_where(at[worst])} the {name} {what}, {found.arcs_mm[worst]:.1f} mm from its entry"
        f" point; at least {parameters.margin_mm:g} mm are asked for"
    ]


def _check_gaps(
    setup: CrispSetup, fine: FineMotion, followed: Followed, parameters: CheckCrispPlansParameters
) -> tuple[list[str], list[Figure]]:
    failures, least = [], np.inf
    for gap in measure_gaps(setup, followed.courses, parameters):
        worst = int(np.argmin(gap.least_mm))
        least = min(least, float(gap.least_mm[worst]))
        if gap.least_mm[worst] <= 0:
            one, other = (name_needle(needle) for needle in gap.needles)
            failures.append(
                f"{say_where(fine.at[worst])} the {one} and the {other} touch or pass through each"
                f" other; only the last {parameters.grasp_mm:g} mm of a snare may touch the tool"
            )
    if not np.isfinite(least):
        return failures, []
    meaning = f"lower bound; the last {parameters.grasp_mm:g} mm of snares may touch the tool"
    return failures, [Figure("least gap between needles", least, "mm", meaning)]


def _check_sheaths(
    setup: CrispSetup,
    fine: FineMotion,
    followed: Followed,
    label_map: LabelMap,
    parameters: CheckCrispPlansParameters,
) -> tuple[list[str], list[Figure]]:
    entries, names = setup.entry_points_patient_mm, ", ".join(parameters.sheath_avoids)
    bone = find_bone(label_map, entries, parameters)
    failures, least = [], np.inf
    at = _between(fine.at[: len(followed.margins)])
    for needle, entry in enumerate(entries):
        tangents = fine.orientations[: len(followed.margins), needle, :, 2]
        radius = setup.needles[needle].outer_diameter_mm / 2
        found = measure_sheath(entry, tangents, radius, bone, parameters)
        worst = int(np.argmin(found.least_mm))
        least = min(least, float(found.least_mm[worst]))
        if found.least_mm[worst] < parameters.margin_mm:
            failures.append(
                f"{say_where(at[worst])} the sheath of the {name_needle(needle)} may come within"
                f" {max(found.least_mm[worst], 0):.3g} mm of {names},"
                f" {found.arcs_mm[worst]:.1f} mm outside of the entry point; at least"
                f" {parameters.margin_mm:g} mm are asked for"
            )
    if not np.isfinite(least):
        return failures, []
    meaning = f"of sheaths that go {parameters.outside_mm:g} mm straight back, a lower bound"
    return failures, [Figure(f"least clearance of sheaths to {names}", least, "mm", meaning)]
