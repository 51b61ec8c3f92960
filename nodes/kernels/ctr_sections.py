"""A concentric tube robot as kernels take it, and the sections that an insertion cuts it into.

Between two breaks (places where a tube ends or its curve starts) the same tubes are there and the
same of them are curved. Sections are numbered from the tip to the base.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from nodes.kernels.ctr_options import INNER

CURVE, TIP = 0, 1  # what breaks: the start of a tube's curve, or its tip
MOST_STEPS = 64  # a section; no robot that can be built needs more than five


class Tubes(NamedTuple):
    """What does not change while the robot moves, innermost tube first.

    bending : (n,) E I, N mm^2.
    torsion : (n,) G J, N mm^2.
    curvature : (n,) of the curved part, 1/mm.
    straight, length : (n,) of the straight part and of all of it, mm.
    weight : (n,) G J as a share of their sum.
    base : (12,) frame of the entry by rows, then its place mm, in the axes that results are in.
    """

    bending: np.ndarray
    torsion: np.ndarray
    curvature: np.ndarray
    straight: np.ndarray
    length: np.ndarray
    weight: np.ndarray
    base: np.ndarray


class Sections(NamedTuple):
    """One insertion, filled by `cut_sections`; 2 n + 1 rows.

    place : (.,) mm, where section k begins at its tip side; `place[count]` is 0, the entry.
    share : (., n) E I kappa / sum of E I of the tubes there, 0 for tubes not there or straight:
        the curvature that the tube gives the robot, 1/mm.
    drive : (., n) E I kappa / G J of the curved tubes, 0 for the others, 1/mm.
    coupled : (.,) bool, whether two tubes are curved, so that they twist each other.
    steps : (.,) int64, how many the section is cut into.
    owner : (., 2) int64, whose break `place` is: the tube, and CURVE or TIP.
    """

    place: np.ndarray
    share: np.ndarray
    drive: np.ndarray
    coupled: np.ndarray
    steps: np.ndarray
    owner: np.ndarray


@njit(**INNER)
def cut_sections(tubes, translations, row, limits, sections):
    """Fill `sections` for the translations in a row and return how many there are.

    Parameters
    ----------
    tubes : Tubes.
    translations : (k, n) beta_i, mm.
    row : which of them.
    limits : longest step as angles: length times the root of the summed squares of the wave
        numbers, and length times curvature.
    sections : Sections, written.
    """
    count = _sort_breaks(tubes, translations, row, sections)
    stiffness = 0.0
    for k in range(count):
        if sections.owner[k, 1] == TIP:
            stiffness += tubes.bending[sections.owner[k, 0]]
        _fill(tubes, k, stiffness, sections)
        _choose_steps(k, limits, sections)
    return count


@njit(**INNER)
def _sort_breaks(tubes, translations, row, sections):
    """Insert all breaks beyond the entry in falling order; equal ones stay in order of tubes, a
    tube's tip before the start of its curve."""
    place, owner = sections.place, sections.owner
    count = 0
    for i in range(tubes.length.shape[0]):
        for end in (TIP, CURVE):
            reach = tubes.length[i] if end == TIP else tubes.straight[i]
            at = translations[row, i] + reach
            if at <= 0.0:
                continue
            k = count
            while k > 0 and place[k - 1] < at:
                place[k] = place[k - 1]
                owner[k, 0], owner[k, 1] = owner[k - 1, 0], owner[k - 1, 1]
                k -= 1
            place[k], owner[k, 0], owner[k, 1] = at, i, end
            count += 1
    place[count] = 0.0
    return count


@njit(**INNER)
def _fill(tubes, k, stiffness, sections):
    """Fill section k from the one before: at its break one tube starts or stops being curved.

    Going by the order of breaks and not by places gives sections of no length their tubes, too.
    """
    for i in range(tubes.length.shape[0]):
        drive = sections.drive[k - 1, i] if k > 0 else 0.0
        if sections.owner[k, 0] == i:
            moment = tubes.bending[i] * tubes.curvature[i]
            drive = moment / tubes.torsion[i] if sections.owner[k, 1] == TIP else 0.0
        sections.drive[k, i] = drive
        sections.share[k, i] = drive * tubes.torsion[i] / stiffness


@njit(**INNER)
def _choose_steps(k, limits, sections):
    """Steps by the wave numbers' sum of squares: the trace of the torsional stiffness matrix."""
    total, squared = 0.0, 0.0
    for i in range(sections.share.shape[1]):
        total += abs(sections.share[k, i])
    for i in range(sections.share.shape[1]):
        squared += abs(sections.drive[k, i]) * (total - abs(sections.share[k, i]))
    length = sections.place[k] - sections.place[k + 1]
    sections.coupled[k] = squared > 0.0
    steps = max(np.sqrt(squared) * length / limits[0], total * length / limits[1])
    sections.steps[k] = min(max(int(np.ceil(steps)), 1), MOST_STEPS)
