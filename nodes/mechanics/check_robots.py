"""Whether a robot can take a configuration; what a robot may be, its own type refuses."""

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.mechanics.check_numbers import check_counts, check_finite, check_inside, check_range
from nodes.mechanics.robots import (
    ConcentricTubeConfiguration,
    ConcentricTubeRobot,
    CrispConfiguration,
    CrispSetup,
    Snare,
)

# Ends that are meant to stand at one place differ by less, since they are sums of lengths.
ROUNDING_MM = 1e-9
MOST_TURN_RAD = 1e6


def check_concentric_tube_configuration(
    robot: ConcentricTubeRobot, configuration: ConcentricTubeConfiguration
) -> None:
    """Refuse joint values that the robot cannot take.

    Bases stand in order behind the entry plane, tips in the opposite order, no tube is drawn in
    completely, and the robot's limits are kept.

    Raises
    ------
    BadInput with the tube and its numbers.
    """
    rotations, translations = configuration.rotations_rad, configuration.translations_mm
    check_counts(
        {
            "tubes": len(robot.tubes),
            "rotations": len(rotations),
            "translations": len(translations),
        }
    )
    check_finite("translations_mm", translations)
    check_finite("rotations_rad", rotations)
    _check_turns(rotations)
    tips = translations + np.array([tube.length_mm for tube in robot.tubes])
    _check_bases(translations)
    _check_tips(tips)
    if robot.translation_limits_mm is not None:
        _check_limits("translations_mm", translations, robot.translation_limits_mm, "mm")
    if robot.rotation_limits_rad is not None:
        _check_limits("rotations_rad", rotations, robot.rotation_limits_rad, "rad")


def _check_turns(rotations: Float[np.ndarray, "tube"]) -> None:
    for tube in np.flatnonzero(abs(rotations) >= MOST_TURN_RAD)[:1]:
        raise BadInput(
            f"rotations_rad[{tube}] = {rotations[tube]:g} rad",
            f"a rotation is below {MOST_TURN_RAD:g} rad, or its digits don't tell where it ends",
            "take whole turns off",
        )


def _check_bases(translations: Float[np.ndarray, "tube"]) -> None:
    ahead = np.append(translations[1:], 0.0)
    for tube in np.flatnonzero(translations > ahead + ROUNDING_MM)[:1]:
        front = (
            "the entry plane" if tube == len(translations) - 1 else f"the base of tubes[{tube + 1}]"
        )
        raise BadInput(
            f"translations_mm[{tube}] = {translations[tube]:g} mm, beyond {front} at"
            f" {ahead[tube]:g} mm",
            "each base lies behind the base of the tube around it, the last behind the entry"
            " plane at 0",
            "make the inner tube's translation smaller (more negative)",
        )


def _check_tips(tips: Float[np.ndarray, "tube"]) -> None:
    around = np.append(tips[1:], 0.0)
    for tube in np.flatnonzero(tips < around - ROUNDING_MM)[:1]:
        last = tube == len(tips) - 1
        where = "behind the entry plane at 0 mm" if last else f"inside of tubes[{tube + 1}], which"
        where += "" if last else f" ends at {around[tube]:g} mm"
        raise BadInput(
            f"tubes[{tube}] ends at {tips[tube]:g} mm, {where}",
            "each tube reaches at least as far as the one around it, the last to the entry plane",
            f"raise translations_mm[{tube}] by at least {around[tube] - tips[tube]:.3g} mm"
            + ("" if last else ", or draw the tubes around it back"),
        )


def _check_limits(
    name: str, values: Float[np.ndarray, "tube"], limits: Float[np.ndarray, "tube 2"], unit: str
) -> None:
    for tube, (value, (low, high)) in enumerate(zip(values, limits, strict=True)):
        check_range(f"{name}[{tube}]", float(value), unit, float(low), float(high))


def grasp_arc_mm(snare: Snare, tool_length_mm: float) -> float:
    """Return where a snare grasps the tool, mm from the tool's entry point."""
    return tool_length_mm - snare.grasp_mm if snare.measured_from == "tip" else snare.grasp_mm


def check_crisp_configuration(setup: CrispSetup, configuration: CrispConfiguration) -> None:
    """Refuse lengths, grasps and loads that no shape of the robot can have.

    Raises
    ------
    BadInput with the needle or load and its numbers.
    """
    lengths = configuration.lengths_mm
    check_counts(
        {
            "needles": len(setup.needles),
            "lengths": len(lengths),
            "orientations": len(configuration.patient_from_entry),
        }
    )
    for needle, length in enumerate(lengths):
        check_inside(f"lengths_mm[{needle}]", float(length), "mm", 0.0)
    for snare in setup.snares:
        _check_grasp(snare, float(lengths[0]))
    for number, load in enumerate(configuration.loads):
        place = f"loads[{number}].arc_length_mm"
        check_range(place, load.arc_length_mm, "mm", 0.0, float(lengths[0]))
    _check_reach(setup, lengths)


def _check_grasp(snare: Snare, tool_length_mm: float) -> None:
    if not 0 < grasp_arc_mm(snare, tool_length_mm) <= tool_length_mm:
        raise BadInput(
            f"needle {snare.needle} grasps the tool {snare.grasp_mm:g} mm from its"
            f" {snare.measured_from}, and {tool_length_mm:g} mm of the tool are inside",
            "a snare grasps the tool between its entry point and its tip",
            "insert the tool farther (lengths_mm[0]), or move the grasp",
        )


def _check_reach(setup: CrispSetup, lengths: Float[np.ndarray, "needle"]) -> None:
    """Refuse needles too short to meet: a way over the tool is no shorter than the straight one."""
    tool = float(lengths[0])
    ends = [(0, 0.0, 0.0)] + [
        (snare.needle, grasp_arc_mm(snare, tool), float(lengths[snare.needle]))
        for snare in setup.snares
    ]
    for index, (one, arc, length) in enumerate(ends):
        for other, other_arc, other_length in ends[:index]:
            points = setup.entry_points_patient_mm[[one, other]]
            straight = float(np.linalg.norm(points[0] - points[1]))
            along = abs(arc - other_arc)
            if straight > length + other_length + along:
                raise _too_short((other, one), (other_length, length), along, straight)


def _too_short(
    needles: tuple[int, int], lengths: tuple[float, float], along: float, straight: float
) -> BadInput:
    parts = [f"needle {n} {x:g} mm" for n, x in zip(needles, lengths, strict=True) if n > 0]
    needed = straight - sum(lengths) - along
    return BadInput(
        f"the entry points of needles {needles[0]} and {needles[1]} are {straight:g} mm apart; "
        + ", ".join(parts)
        + f" and {along:g} mm of the tool between reach {sum(lengths) + along:g} mm",
        "a needle is no shorter than the straight way to what it grasps",
        f"make one of them at least {needed:.3g} mm longer",
    )
