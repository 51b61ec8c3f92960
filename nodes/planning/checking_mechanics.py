"""Whether a motion is what the robot does: stable, unbroken, as strong as it is, as was claimed."""

import numpy as np
from jaxtyping import Float

from nodes.mechanics.describe_robots import name_needle
from nodes.mechanics.robots import CrispSetup
from nodes.mechanics.shapes import Figure
from nodes.planning.artefacts import CrispMotion, MotionPlan
from nodes.planning.checking_shapes import Followed, rest_at_start
from nodes.planning.checking_steps import FineMotion, joint_ways, say_where
from nodes.planning.parameters import CheckCrispPlansParameters


def check_mechanics(
    plan: MotionPlan,
    fine: FineMotion,
    followed: Followed,
    parameters: CheckCrispPlansParameters,
) -> tuple[list[str], list[Figure]]:
    """Return what a motion breaks of mechanics, and its figures."""
    failures = [followed.lost] if followed.lost else []
    if not len(followed.margins):
        return failures, []
    setup = plan.placed.setup
    parts = [
        _check_rest(setup, fine, followed, parameters),
        _check_stability(fine, followed, parameters),
        _check_snaps(fine, followed, parameters),
        _check_claims(plan.motion, setup, fine, followed, parameters),
        _check_strains(setup, fine, followed),
    ]
    figures = []
    for broken, told in parts:
        failures += broken
        figures += told
    return failures, figures + _tell_wrenches(followed)


def _check_rest(
    setup: CrispSetup, fine: FineMotion, followed: Followed, parameters: CheckCrispPlansParameters
) -> tuple[list[str], list[Figure]]:
    """Refuse a start in which the robot would rest in another shape."""
    rest = rest_at_start(setup, fine, parameters)
    if rest.status != "solved":
        return [f"at step 0 the robot finds no stable shape: {rest.reason}"], []
    length = fine.lengths_mm[0].max()
    away = _differ(setup, rest.base_wrenches, followed.wrenches[0], float(length))
    if away <= parameters.agreement_mm:
        return [], []
    return [
        "at step 0 the robot rests in another shape, of less energy: its camera is"
        f" {np.linalg.norm(rest.patient_from_camera[:3, 3] - followed.cameras[0, :3, 3]):.3g} mm"
        " from where the motion begins"
    ], []


def _check_stability(
    fine: FineMotion, followed: Followed, parameters: CheckCrispPlansParameters
) -> tuple[list[str], list[Figure]]:
    worst = int(np.argmin(followed.margins))
    least, failures = float(followed.margins[worst]), []
    if least < parameters.least_margin:
        failures.append(
            f"{say_where(fine.at[worst])} the stability margin is {least:.3g}; at least"
            f" {parameters.least_margin:g} is asked for"
        )
    meaning = "1 for a free robot; it falls towards 0, where the robot snaps to another shape"
    return failures, [Figure("smallest stability margin", least, "", meaning)]


def _check_snaps(
    fine: FineMotion, followed: Followed, parameters: CheckCrispPlansParameters
) -> tuple[list[str], list[Figure]]:
    """Refuse jumps of the camera that no motion of the joints explains."""
    places, count = followed.cameras[:, :3, 3], len(followed.margins)
    moved = np.linalg.norm(np.diff(places, axis=0), axis=1)
    ways = joint_ways(fine, float(fine.lengths_mm.max()))[: count - 1]
    # What the solver leaves open moves the camera, too, where the joints all but stand still.
    gains = np.maximum(moved - parameters.agreement_mm, 0.0) / np.maximum(ways, 1e-12)
    failures = []
    if gains.size and gains.max() > parameters.snap_gain:
        worst = int(np.argmax(gains))
        failures.append(
            f"between steps {int(fine.at[worst])} and {int(np.ceil(fine.at[worst + 1]))} the robot"
            f" snaps: the camera moves by {moved[worst]:.3g} mm while the joints move by"
            f" {ways[worst]:.3g} mm; at most {parameters.snap_gain:g} times as far is allowed"
        )
    steps = np.floor(fine.at[:count]) == fine.at[:count]
    strides = np.linalg.norm(np.diff(places[steps], axis=0), axis=1)
    return failures, [
        Figure("largest motion of the camera in a step", float(strides.max(initial=0.0)), "mm",
               "between two steps of the motion"),
        Figure("way of the camera", float(moved.sum()), "mm", "from the start to the end"),
    ]  # fmt: skip


def _check_claims(
    motion: CrispMotion,
    setup: CrispSetup,
    fine: FineMotion,
    followed: Followed,
    parameters: CheckCrispPlansParameters,
) -> tuple[list[str], list[Figure]]:
    """Refuse wrenches and camera poses that are not those of the robot at the motion's steps."""
    count = len(followed.margins)
    own = np.flatnonzero(np.floor(fine.at[:count]) == fine.at[:count])
    failures, worst = [], 0.0
    for step, row in enumerate(own):
        length = float(fine.lengths_mm[row].max())
        claimed = motion.patient_from_camera[step]
        turned = np.linalg.norm(claimed[:3, :3] - followed.cameras[row, :3, :3])
        away = np.linalg.norm(claimed[:3, 3] - followed.cameras[row, :3, 3]) + length * turned
        off = max(
            float(away), _differ(setup, motion.wrenches[step], followed.wrenches[row], length)
        )
        worst = max(worst, off)
        if off > parameters.agreement_mm and not failures:
            failures.append(
                f"step {step} is not what the robot does: camera pose or wrenches are off by"
                f" {off:.3g} mm at the tip; at most {parameters.agreement_mm:g} mm are allowed"
            )
    meaning = "of camera poses and wrenches, as what they move at the tip"
    return failures, [Figure("largest difference to the planner", worst, "mm", meaning)]


def _differ(
    setup: CrispSetup,
    one: Float[np.ndarray, "needle 6"],
    other: Float[np.ndarray, "needle 6"],
    length: float,
) -> float:
    """Return by how much differences of wrenches move the end of a needle of that length, mm: F L^3
    / 3 E I and M L^2 / 2 E I, as of a cantilever."""
    soft = 1 / np.array([needle.bending_stiffness for needle in setup.needles])
    moments = np.linalg.norm((one - other)[:, :3], axis=1) * soft * length**2 / 2
    forces = np.linalg.norm((one - other)[:, 3:], axis=1) * soft * length**3 / 3
    return float(max(moments.max(), forces.max()))


def _check_strains(
    setup: CrispSetup, fine: FineMotion, followed: Followed
) -> tuple[list[str], list[Figure]]:
    failures, largest = [], 0.0
    for number, needle in enumerate(setup.needles):
        worst = int(np.argmax(followed.strains[:, number]))
        strain, most = float(followed.strains[worst, number]), needle.material.recoverable_strain
        largest = max(largest, strain)
        if strain > most:
            failures.append(
                f"{say_where(fine.at[worst])} the {name_needle(number)} is strained by"
                f" {100 * strain:.3g} %; {needle.material.name} comes back from {100 * most:.3g} %"
            )
    meaning = "of bending at a needle's surface; what comes back from it depends on the material"
    return failures, [Figure("largest strain", 100 * largest, "%", meaning)]


def _tell_wrenches(followed: Followed) -> list[Figure]:
    """Return the largest force and moment at each entry point."""
    figures = []
    for needle in range(followed.wrenches.shape[1]):
        name = name_needle(needle)
        moments, forces = (
            np.linalg.norm(followed.wrenches[:, needle, part], axis=1)
            for part in (slice(0, 3), slice(3, 6))
        )
        meaning = "that the needle exerts on its sheath where it enters"
        figures += [
            Figure(f"largest force at the entry of the {name}", float(forces.max()), "N", meaning),
            Figure(
                f"largest moment at the entry of the {name}", float(moments.max()), "N mm", meaning
            ),
        ]
    return figures
