"""Ventricles among clefts and cisterns that are as dark."""

from pathlib import Path

import numpy as np
import yaml
from scipy import ndimage

from nodes.imaging.mri_ventricles import find_ventricles
from nodes.imaging.parameters import SegmentMriParameters

DEFAULTS = Path(__file__).resolve().parents[3] / "catalog" / "parameters" / "segment_mri.yml"
PARAMETERS = SegmentMriParameters(**yaml.safe_load(DEFAULTS.read_text()))
SHAPE, SIZE = (70, 84, 70), 2.0
X, Y, Z = (np.indices(SHAPE).T - np.array([34.5, 42, 35])).T * SIZE
BRAIN = (X / 64) ** 2 + (Y / 80) ** 2 + (Z / 64) ** 2 < 1


def ball(x, half_axes=(7, 25, 9)) -> np.ndarray:
    return ((X - x) / half_axes[0]) ** 2 + (Y / half_axes[1]) ** 2 + (Z / half_axes[2]) ** 2 < 1


def find(*dark):
    values = np.where(BRAIN, 1, 0).astype(np.float32)
    for mask in dark:
        values[mask] = 0.25
    return find_ventricles(values, BRAIN, X.astype(np.float32), SIZE, PARAMETERS)


PAIR = ball(13) | ball(-13)


def test_a_pair_is_found_and_clefts_and_cisterns_are_left():
    cleft = BRAIN & (abs(X) < 2) & (Z > 15)
    fissures = BRAIN & (abs(X) > 45) & (abs(Z) < 3)
    cistern = ball(0, (12, 12, 8)) & (abs(X) < 12)
    cistern = np.roll(cistern, (20, -15), (1, 2))
    found = find(PAIR, cleft, fissures, cistern)
    assert 2 * (found & PAIR).sum() / (found.sum() + PAIR.sum()) > 0.95


def test_what_joins_the_two_belongs_to_them():
    joint = BRAIN & (abs(X) < 14) & (abs(Y) < 4) & (abs(Z) < 4)
    assert ndimage.label(find(PAIR, joint))[1] == 1 < ndimage.label(find(PAIR))[1]


def test_one_dark_part_is_no_pair():
    assert find(ball(13)) is None


def test_too_little_and_too_much_are_not_taken():
    assert find(ball(13, (3, 5, 3)) | ball(-13, (3, 5, 3))) is None
    assert find(ball(24, (20, 45, 30)) | ball(-24, (20, 45, 30))) is None
