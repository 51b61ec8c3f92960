"""What no snare and no CRISP setup can be: joints, entry points, who grasps whom."""

from collections import Counter

import numpy as np
from jaxtyping import Float

from nodes.errors import BadInput
from nodes.mechanics.check_numbers import check_inside, check_range


def check_joint(joint: str, cosine: float, grasp_mm: float) -> None:
    """Refuse a grasp before the tool's entry or beyond its tip, and an angle that no joint has.

    Parameters
    ----------
    joint : "rigid" or "relaxed".
    cosine : between the tangents of tool and snare.
    grasp_mm : place on the tool from where it is measured, mm.

    Raises
    ------
    BadInput with the number.
    """
    check_range("grasp_mm", grasp_mm, "mm", 0.0)
    check_inside("cosine", cosine, "", -1.0, 1.0)
    if joint == "rigid" and cosine != 0:
        raise BadInput(
            f"cosine = {cosine:g} at a rigid joint",
            "a rigid joint holds the snare at right angles to the tool [Kuntz2017]",
            "leave the cosine out, or make the joint relaxed",
        )


def check_snares(grasping: tuple[int, ...], needles: int) -> None:
    """Refuse needles that do not grasp the tool, or do so twice.

    Parameters
    ----------
    grasping : needle of each snare.
    needles : how many there are, with the tool, which is needle 0.

    Raises
    ------
    BadInput with the needles that snares and setup name.
    """
    if needles < 1:
        raise BadInput("no needles", "needle 0 is the tool", "list the tool and its snares")
    times = Counter(grasping)
    for needle in sorted(set(times) | set(range(1, needles))):
        if times[needle] != 1 or not 1 <= needle < needles:
            raise BadInput(
                f"needle {needle} grasps {times[needle]} times; there are the tool, needle 0, and"
                f" {needles - 1} other needles",
                "each needle but the tool has one snare at its tip",
                "give each needle from 1 on one snare, or leave the needle out",
            )


def check_entries_apart(
    entry_points_mm: Float[np.ndarray, "needle 3"], radii_mm: tuple[float, ...]
) -> None:
    """Refuse entry points at which needles would lie in each other.

    Parameters
    ----------
    entry_points_mm : (needle, 3) mm.
    radii_mm : outer radii of the needles, mm.

    Raises
    ------
    BadInput with the distance and the radii.
    """
    for one in range(len(radii_mm)):
        for other in range(one):
            apart = float(np.linalg.norm(entry_points_mm[one] - entry_points_mm[other]))
            if apart < radii_mm[one] + radii_mm[other]:
                raise BadInput(
                    f"needles {other} and {one}, of radii {radii_mm[other]:g} and"
                    f" {radii_mm[one]:g} mm, enter {apart:g} mm apart",
                    "needles do not enter through each other",
                    "move one of entry_points_patient_mm",
                )
