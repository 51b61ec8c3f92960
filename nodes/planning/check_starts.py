"""Refuse set-ups that cannot be planned with, and offer starts that can."""

import numpy as np

from nodes.errors import BadInput
from nodes.mechanics.check_numbers import check_counts, check_inside
from nodes.mechanics.check_robots import grasp_arc_mm
from nodes.planning.artefacts import PlacedSetup
from nodes.planning.setup_judging import Scene, find_tilts, judge_starts, say_why
from nodes.planning.setup_nearest import Search, find_nearest, write_start

ROUNDING = 1e-6  # rad and mm, by which what is meant to be at a limit may be beyond it


def check_kind(placed: PlacedSetup) -> None:
    """Refuse what planning cannot take: curved needles and loads, and numbers beyond limits.

    Raises
    ------
    BadInput with the needle and its numbers.
    """
    start = placed.start
    for number, needle in enumerate(placed.setup.needles):
        if needle.precurvature_per_mm.any():
            raise BadInput(
                f"{placed.name}: needle {number} is curved when nothing bends it",
                "plans are made for straight needles",
                "leave precurvature_per_mm out",
            )
    if start.loads:
        raise BadInput(
            f"{placed.name}: {len(start.loads)} loads on the tool at the start",
            "plans are made for robots on which nothing pulls",
            "leave loads out",
        )
    _check_numbers(placed)
    tilts = find_tilts(placed, start.patient_from_entry[None])[0]
    limits = zip(
        tilts, placed.largest_tilts_rad, start.lengths_mm, placed.shortest_mm, placed.longest_mm,
        strict=True,
    )  # fmt: skip
    for number, (tilt, largest, length, shortest, longest) in enumerate(limits):
        if tilt > largest + ROUNDING:
            raise BadInput(
                f"{placed.name}: needle {number} starts {np.degrees(tilt):.1f} degrees from its"
                " axis",
                f"it tilts by at most {np.degrees(largest):.1f} degrees",
                "turn it towards its axis, or raise its largest tilt",
            )
        if not shortest - ROUNDING <= length <= longest + ROUNDING:
            raise BadInput(
                f"{placed.name}: needle {number} starts {length:g} mm inside",
                f"it is {shortest:g} to {longest:g} mm inside",
                "change its length at the start, or its limits",
            )


def _check_numbers(placed: PlacedSetup) -> None:
    """Refuse starts that are not of this robot; needles too short to meet get an offer instead."""
    lengths = placed.start.lengths_mm
    check_counts(
        {
            "needles": len(placed.setup.needles),
            "lengths": len(lengths),
            "orientations": len(placed.start.patient_from_entry),
            "axes": len(placed.axes),
            "limits": len(placed.longest_mm),
        }
    )
    for number, length in enumerate(lengths):
        check_inside(f"lengths_mm[{number}]", float(length), "mm", 0.0)
    for snare in placed.setup.snares:
        if not 0 < grasp_arc_mm(snare, float(lengths[0])) <= lengths[0]:
            raise BadInput(
                f"{placed.name}: needle {snare.needle} grasps the tool {snare.grasp_mm:g} mm from"
                f" its {snare.measured_from}, and {lengths[0]:g} mm of the tool are inside",
                "a snare grasps the tool between its entry point and its tip",
                "insert the tool farther at the start, or move the grasp",
            )


def check_start(placed: PlacedSetup, scene: Scene, search: Search) -> None:
    """Refuse a start that touches something or has no solution, and offer the nearest that works.

    Raises
    ------
    BadInput with the reason and, as lines of a configuration file, the other start.
    """
    start = placed.start
    code = int(
        judge_starts(placed.setup, start.patient_from_entry[None], start.lengths_mm[None], scene)[0]
    )
    if code:
        raise BadInput(
            f"{placed.name}: the start {say_why(code)}",
            "a robot begins in an equilibrium in which it touches nothing, with"
            f" margin_mm = {scene.clearances.margin_mm:g} mm of room",
            _offer(placed, scene, search),
        )


def _offer(placed: PlacedSetup, scene: Scene, search: Search) -> str:
    offer = find_nearest(placed, scene, search)
    if offer is None:
        return (
            "move entry points, lengths or directions: no start that works was found within"
            f" {search.farthest:g} degrees and mm; or hand in no set-ups, and let one be chosen"
        )
    return (
        f"begin with the nearest start that was found, {offer.distance:.1f} degrees and mm away"
        f" over all joints:\n{write_start(offer.start)}"
    )
