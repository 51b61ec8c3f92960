"""Where the integration of one configuration stops: from the tip (node 0) to the entry."""

from typing import NamedTuple

import numpy as np


class Nodes(NamedTuple):
    """Scratch for one configuration; step k lies between node k and node k + 1.

    place : (.,) mm from the entry.
    section : (.,) int64, section of step k.
    state, rate : (., m + m m) the m angles to the innermost tube and their derivatives by the
        angles at the tip, column after column; and their rates by arc length.
    shift, shift_rate, shift_end : (., m + m m) the same with derivatives by the translations of all
        tubes but the innermost; the rates of step k at its upper and at its lower end, since they
        jump at breaks.
    frame : (., 12) innermost tube's frame by rows, then position mm, in the base frame.
    bend : (., 14) of step k at its lower and at its upper end, in its evenly turning frame:
        rotation vector by arc length, first and second derivative of its x and y.
    turning : (., 9) that frame at the upper end; at the lower it is the innermost tube's.
    """

    place: np.ndarray
    section: np.ndarray
    state: np.ndarray
    rate: np.ndarray
    shift: np.ndarray
    shift_rate: np.ndarray
    shift_end: np.ndarray
    frame: np.ndarray
    bend: np.ndarray
    turning: np.ndarray
