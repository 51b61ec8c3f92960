"""Where the integration of one configuration stops: from the tip (node 0) to the entry."""

from typing import NamedTuple

import numpy as np

# Rows of a block of lanes, one lane for each step: its length in row 0, the motion of the innermost
# tube's frame over it (rotation by rows, translation), the rotation of the frame that turns evenly,
# its rotation vector by arc length at the lower and at the upper end, with first and second
# derivatives of x and y, coefficients of the polynomials through points, what goes in.
MOTION, TURNING, LOW_BEND, HIGH_BEND, CURVE, INPUTS, ROWS = 1, 13, 22, 29, 36, 60, 92

# Rows of `ends`, one lane for each step again: frame, arm to the tip, angles and rates of columns,
# for each tube five numbers and 18 that say what its angle does to the tip, sums of all columns.
FRAME, ARM, ANGLES, RATES, TUBES, TUBE, SUMS, END_ROWS = 0, 9, 12, 30, 48, 23, 140, 176


class Nodes(NamedTuple):
    """Scratch for one configuration; step k lies between node k and node k + 1.

    place : (.,) mm from the entry.
    section : (.,) int64, section of step k.
    state, rate : (., m + m m) the m angles to the innermost tube and their derivatives by the
        angles at the tip, column after column; and their rates by arc length.
    shift, shift_rate, shift_end : (., m + m m) the same with derivatives by the translations of all
        tubes but the innermost; the rates of step k at its upper and at its lower end, since they
        jump at breaks.
    frame : (., 12) innermost tube's frame by rows, then position mm.
    lanes : (., 8) blocks of `ROWS` rows for eight steps each, see above.
    ends : (176, 8) of one end of eight steps, see above.
    samples : (., 3) points, with room for eight more than asked for.
    """

    place: np.ndarray
    section: np.ndarray
    state: np.ndarray
    rate: np.ndarray
    shift: np.ndarray
    shift_rate: np.ndarray
    shift_end: np.ndarray
    frame: np.ndarray
    lanes: np.ndarray
    ends: np.ndarray
    samples: np.ndarray
