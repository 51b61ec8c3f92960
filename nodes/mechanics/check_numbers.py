"""Rules that hold for any number, row of numbers and rotation that describes a robot."""

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput

# Products of a rotation's columns in double precision stay below this by far; text is mended when
# it is read.
ROTATION_TOLERANCE = 1e-9


def check_range(name: str, value: float, unit: str, least: float, most: float = np.inf) -> None:
    """Refuse a number that is not finite, below `least` or above `most`.

    Parameters
    ----------
    name, unit : as a person wrote it, for the error; unit "" where it has none.

    Raises
    ------
    BadInput with the number and the rule.
    """
    if not (np.isfinite(value) and least <= value <= most):
        range_ = f"at least {least:g}" if most == np.inf else f"from {least:g} to {most:g}"
        raise _out_of_range(name, value, unit, range_)


def check_inside(name: str, value: float, unit: str, low: float, high: float = np.inf) -> None:
    """Refuse a number that is not finite, or not strictly between two others."""
    if not (np.isfinite(value) and low < value < high):
        range_ = f"above {low:g}" if high == np.inf else f"between {low:g} and {high:g}"
        raise _out_of_range(name, value, unit, range_)


def _out_of_range(name: str, value: float, unit: str, range_: str) -> BadInput:
    unit = f" {unit}" if unit else ""
    return BadInput(
        f"{name} = {value:g}{unit}",
        f"it is a finite number, {range_}{unit}",
        f"give {name} such a number",
    )


def check_finite(name: str, values: Float[np.ndarray, "*shape"]) -> None:
    """Refuse a row or table that holds an infinite number or none."""
    if not np.isfinite(values).all():
        raise BadInput(
            f"{name} = {values.tolist()}", "all numbers are finite", f"mend the numbers of {name}"
        )


def check_counts(counts: dict[str, int]) -> None:
    """Refuse rows of different lengths that must say one thing a tube each."""
    if len(set(counts.values())) > 1:
        found = ", ".join(f"{name}: {count}" for name, count in counts.items())
        raise BadInput(
            found, "each tube has one of each", "add what is missing, or leave tubes out"
        )


def check_limits(name: str, limits: Float[np.ndarray, "rows 2"] | None, tubes: int) -> None:
    """Refuse limits that are not least and largest number of each tube; None are none."""
    if limits is None:
        return
    check_counts({"tubes": tubes, name: len(limits)})
    for tube, (low, high) in enumerate(limits):
        if not low <= high:  # also where one of them is no number
            raise BadInput(
                f"{name}[{tube}] = {low:g} to {high:g}",
                "the least number stands first, the largest second",
                "swap them",
            )


def check_rotation(name: str, rotation: Float[np.ndarray, "3 3"]) -> None:
    """Refuse a matrix that is no rotation: columns of length 1 at right angles, right-handed."""
    check_finite(name, rotation)
    off = float(abs(rotation.T @ rotation - np.eye(3)).max())
    mirrored = np.linalg.det(rotation) < 0
    if mirrored or off > ROTATION_TOLERANCE:
        found = "is mirrored" if mirrored else f"is off from a rotation by {off:.2g}"
        raise BadInput(
            f"{name} {found}",
            f"the columns have length 1, are at right angles to {ROTATION_TOLERANCE:g} and"
            " right-handed",
            "write the axes as columns with all digits, or give a quaternion or a direction",
        )


def check_pose(name: str, pose: Float[np.ndarray, "4 4"]) -> None:
    """Refuse a matrix that is no rotation with a place."""
    check_finite(name, pose)
    check_rotation(name, pose[:3, :3])
    if pose[3].tolist() != [0, 0, 0, 1]:
        raise BadInput(
            f"{name}: its last line is {pose[3].tolist()}",
            "the last line of a rigid transform is 0 0 0 1",
            "write the axes as columns, and the place as last column",
        )
