"""What no single tube and no nest of tubes can be: diameters, lengths, strain."""

from itertools import pairwise

import numpy as np

from nodes.errors import BadInput
from nodes.mechanics.check_numbers import check_inside, check_range

MOST_TUBES = 4  # beyond, no published robot goes; one tube alone is an arc, and a useful test


def check_diameters(inner_mm: float, outer_mm: float) -> None:
    """Refuse diameters that leave no wall; inner 0 is a wire.

    Raises
    ------
    BadInput with both diameters.
    """
    check_inside("outer_diameter_mm", outer_mm, "mm", 0.0)
    check_range("inner_diameter_mm", inner_mm, "mm", 0.0)
    if inner_mm >= outer_mm:
        raise BadInput(
            f"inner_diameter_mm = {inner_mm:g}, outer_diameter_mm = {outer_mm:g}",
            "the inner diameter is smaller than the outer one",
            "swap them, or write diameters of a tube with a wall",
        )


def check_lengths(straight_mm: float, curved_mm: float) -> None:
    """Refuse a negative length, and a tube without any."""
    check_range("straight_length_mm", straight_mm, "mm", 0.0)
    check_range("curved_length_mm", curved_mm, "mm", 0.0)
    if straight_mm + curved_mm == 0:
        raise BadInput(
            "straight_length_mm = 0 and curved_length_mm = 0",
            "a tube has a length",
            "give one of the two a number above 0",
        )


def check_strain(
    name: str, bending_per_mm: float, twist_per_mm: float, outer_mm: float, recoverable: float
) -> None:
    """Refuse a pre-curvature that the material does not come back from when it is straightened.

    At the surface of the straightened tube the strain along it is e = kappa OD / 2 and the shear
    from its twist g = tau OD / 2, so that the largest strain in any direction is
    e / 2 + sqrt(e^2 + g^2) / 2 (Mohr's circle; the strain across, nu e, is left out).

    Parameters
    ----------
    name : of the curvature, as a person wrote it.
    bending_per_mm, twist_per_mm : of the tube when nothing bends it, 1/mm.
    outer_mm : outer diameter, mm.
    recoverable : the material's largest strain from which it comes back.

    Raises
    ------
    BadInput with the strain, and the largest curvature that the tube can have.
    """
    check_range(name, bending_per_mm, "1/mm", -np.inf)
    check_range(name, twist_per_mm, "1/mm", -np.inf)
    reached = (abs(bending_per_mm) + np.hypot(bending_per_mm, twist_per_mm)) / 2
    most = 2 * recoverable / outer_mm
    if reached > most:
        twist = f" with a twist of {twist_per_mm:g} 1/mm" if twist_per_mm else ""
        raise BadInput(
            f"{name} = {bending_per_mm:g} 1/mm{twist} strains a tube of outer diameter"
            f" {outer_mm:g} mm by {reached * outer_mm / 2:.2%} when it is straightened",
            f"its material comes back from {recoverable:.2%}",
            f"curve it by at most {most:.4g} 1/mm (a radius of {1 / most:.4g} mm), or take a"
            " thinner tube",
        )


def check_nest(
    inner_mm: tuple[float, ...], outer_mm: tuple[float, ...], lengths_mm: tuple[float, ...]
) -> None:
    """Refuse tubes that do not lie in each other, or whose inner one is shorter.

    Parameters
    ----------
    inner_mm, outer_mm : diameters, mm, innermost tube first.
    lengths_mm : straight and curved part together, mm.

    Raises
    ------
    BadInput with the diameters or lengths of the two tubes.
    """
    if not 1 <= len(outer_mm) <= MOST_TUBES:
        raise BadInput(
            f"{len(outer_mm)} tubes",
            f"a concentric tube robot has 1 to {MOST_TUBES} tubes",
            "list the tubes, the innermost first",
        )
    for tube, (outer, inner) in enumerate(zip(outer_mm, inner_mm[1:], strict=False)):
        if outer > inner:
            raise BadInput(
                f"tubes[{tube}] has outer diameter {outer:g} mm, tubes[{tube + 1}] around it has"
                f" inner diameter {inner:g} mm",
                "tubes are listed innermost first, and each fits into the next",
                "reorder the tubes, or take a wider outer or a thinner inner one",
            )
    for tube, (length, next_length) in enumerate(pairwise(lengths_mm)):
        if length < next_length:
            raise BadInput(
                f"tubes[{tube}] is {length:g} mm long, tubes[{tube + 1}] around it"
                f" {next_length:g} mm",
                "no tube is shorter than the one around it, or it could not be driven",
                "lengthen the straight part of the inner tube",
            )
