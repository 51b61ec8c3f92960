"""A motion cut finely, and whether it is one: numbers, rotations, start, limits, size of steps."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from nodes.mechanics.describe_robots import name_needle
from nodes.mechanics.robots import CrispSetup
from nodes.mechanics.shapes import Figure
from nodes.planning.artefacts import CrispMotion, PlacedSetup
from nodes.planning.parameters import CheckCrispPlansParameters

ROUNDING = 1e-6  # of angles in rad and lengths in mm that were written and read, or turned
PlacesAlong = Float[np.ndarray, "c"]


class FineMotion(NamedTuple):
    """Configurations along a motion.

    Parameters
    ----------
    at : (c,) step of the motion that each belongs to; 2.5 is half-way from step 2 to step 3.
    orientations : (c, needle, 3, 3).
    lengths_mm : (c, needle).
    """

    at: np.ndarray
    orientations: np.ndarray
    lengths_mm: np.ndarray


def cut_finely(motion: CrispMotion, resolution: int) -> FineMotion:
    """Return `resolution` configurations for each step: SLERP of orientations, lengths evenly."""
    from scipy.spatial.transform import Rotation, Slerp

    steps, needles = motion.lengths_mm.shape
    if steps == 1:
        return FineMotion(np.zeros(1), motion.orientations, motion.lengths_mm)
    at = np.arange((steps - 1) * resolution + 1) / resolution
    own = np.arange(steps)
    turned = [
        Slerp(own, Rotation.from_matrix(motion.orientations[:, needle]))(at).as_matrix()
        for needle in range(needles)
    ]
    lengths = [np.interp(at, own, motion.lengths_mm[:, needle]) for needle in range(needles)]
    return FineMotion(at, np.stack(turned, axis=1), np.stack(lengths, axis=1))


def find_nonsense(motion: CrispMotion, setup: CrispSetup) -> list[str]:
    """Return what makes a motion none of this robot; then nothing else can be looked at."""
    needles = len(setup.needles)
    if not len(motion.lengths_mm):
        return ["the motion has no steps"]
    if motion.lengths_mm.shape[1] != needles:
        return [f"the motion is of {motion.lengths_mm.shape[1]} needles, the robot has {needles}"]
    numbers = (motion.orientations, motion.lengths_mm, motion.wrenches, motion.patient_from_camera)
    if not all(np.isfinite(values).all() for values in numbers):
        return ["a joint value, wrench or camera pose is no finite number"]
    turns = motion.orientations
    off = abs(np.swapaxes(turns, 2, 3) @ turns - np.eye(3)).max(axis=(1, 2, 3))
    wrong = (off > ROUNDING) | (np.linalg.det(turns) < 0).any(axis=1)
    if wrong.any():
        return [f"step {_first(wrong)}: an orientation is no rotation"]
    bottom = abs(motion.patient_from_camera[:, 3] - [0, 0, 0, 1]).max(axis=1)
    if (bottom > 0).any():
        return [
            f"step {_first(bottom > 0)}: the camera's pose is none: its last row is not 0 0 0 1"
        ]
    short = (motion.lengths_mm <= 0).any(axis=1)
    for snare in setup.snares:
        short |= motion.lengths_mm[:, 0] <= snare.grasp_mm
    if short.any():
        return [f"step {_first(short)}: a needle is not inside as far as it is grasped"]
    return []


def check_start(motion: CrispMotion, placed: PlacedSetup) -> list[str]:
    """Return what differs between the motion's first step and the start of the robot."""
    turned = np.degrees(_angles(motion.orientations[0], placed.start.patient_from_entry))
    moved = abs(motion.lengths_mm[0] - placed.start.lengths_mm)
    return [
        f"step 0 is not the start of the robot: the {name_needle(needle)} is turned by"
        f" {turned[needle]:.3g} degrees and moved by {moved[needle]:.3g} mm"
        for needle in range(len(moved))
        if turned[needle] > np.degrees(ROUNDING) or moved[needle] > ROUNDING
    ]


def check_limits(fine: FineMotion, placed: PlacedSetup) -> list[str]:
    """Return where tilts and lengths leave the limits of the setup."""
    tangents, failures = fine.orientations[:, :, :, 2], []
    for needle in range(fine.lengths_mm.shape[1]):
        name, lengths = name_needle(needle), fine.lengths_mm[:, needle]
        across = np.cross(tangents[:, needle], placed.axes[needle])
        tilts = np.arctan2(
            np.linalg.norm(across, axis=1), tangents[:, needle] @ placed.axes[needle]
        )
        most = placed.largest_tilts_rad[needle]
        if tilts.max() > most + ROUNDING:
            worst = int(np.argmax(tilts))
            failures.append(
                f"{say_where(fine.at[worst])} the {name} tilts by {np.degrees(tilts[worst]):.4g}"
                f" degrees; at most {np.degrees(most):.4g} are allowed"
            )
        low, high = placed.shortest_mm[needle], placed.longest_mm[needle]
        worst = int(np.argmax(np.maximum(low - lengths, lengths - high)))
        if lengths[worst] < low - ROUNDING or lengths[worst] > high + ROUNDING:
            failures.append(
                f"{say_where(fine.at[worst])} the {name} is {lengths[worst]:.4g} mm long; between"
                f" {low:.4g} and {high:.4g} mm are allowed"
            )
    return failures


def check_joint_steps(
    motion: CrispMotion, parameters: CheckCrispPlansParameters
) -> tuple[list[str], list[Figure]]:
    """Return steps of joints that are too large, and the largest ones."""
    turns = np.degrees(_angles(motion.orientations[:-1], motion.orientations[1:]))
    shifts = abs(np.diff(motion.lengths_mm, axis=0))
    failures = []
    for values, most, unit, what in (
        (turns, parameters.largest_step_deg, "degrees", "turns by"),
        (shifts, parameters.largest_step_mm, "mm", "moves by"),
    ):
        if values.size and values.max() > most:
            step, needle = np.unravel_index(np.argmax(values), values.shape)
            failures.append(
                f"from step {step} to step {step + 1} the {name_needle(int(needle))} {what}"
                f" {values[step, needle]:.4g} {unit}; at most {most:g} are allowed"
            )
    return failures, [
        Figure("largest turn of a step", float(turns.max(initial=0.0)), "deg",
               f"of a needle between two steps; at most {parameters.largest_step_deg:g}"),
        Figure("largest shift of a step", float(shifts.max(initial=0.0)), "mm",
               f"of a needle's length; at most {parameters.largest_step_mm:g}"),
    ]  # fmt: skip


def joint_ways(fine: FineMotion, reach_mm: float) -> PlacesAlong:
    """Return how far each configuration's joints are from the last one's, mm: shifts, and turns
    with a lever as long as the robot reaches."""
    turns = _angles(fine.orientations[:-1], fine.orientations[1:]).sum(axis=1)
    return reach_mm * turns + abs(np.diff(fine.lengths_mm, axis=0)).sum(axis=1)


def say_where(at: float) -> str:
    """Return where along a motion something is, in words."""
    step = int(np.floor(at))
    return f"at step {step}" if at == step else f"between steps {step} and {step + 1}"


def _angles(
    one: Float[np.ndarray, "*batch 3 3"], other: Float[np.ndarray, "*batch 3 3"]
) -> Float[np.ndarray, "*batch"]:
    """Return by how much rotations differ, rad."""
    turn = np.swapaxes(one, -1, -2) @ other
    across = turn - np.swapaxes(turn, -1, -2)
    sine = np.sqrt(across[..., 0, 1] ** 2 + across[..., 0, 2] ** 2 + across[..., 1, 2] ** 2) / 2
    return np.arctan2(sine, (np.trace(turn, axis1=-2, axis2=-1) - 1) / 2)


def _first(which: np.ndarray) -> int:
    return int(np.flatnonzero(which)[0])


def least_at_steps(
    values: Float[np.ndarray, "m"], at: Float[np.ndarray, "m"], fine: FineMotion
) -> Float[np.ndarray, "step"]:
    """Return the least value nearest to each of the motion's own steps; nan where there is none."""
    steps = round(float(fine.at[-1])) + 1
    least = np.full(steps, np.inf)
    np.minimum.at(least, np.minimum(np.floor(at + 0.5).astype(int), steps - 1), values)
    return np.where(np.isfinite(least), least, np.nan)
