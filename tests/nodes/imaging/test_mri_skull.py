"""The skull's estimate on balls whose layers are known."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from nodes.imaging.mri_skull import find_braincase, find_skull, open_base, shell_skull
from nodes.imaging.parameters import SegmentMriParameters

DEFAULTS = Path(__file__).resolve().parents[3] / "catalog" / "parameters" / "segment_mri.yml"
PARAMETERS = SegmentMriParameters(**yaml.safe_load(DEFAULTS.read_text()))
SHAPE, MIDDLE = (90, 90, 90), np.array([44.0, 45.0, 45.5])
distance = np.linalg.norm(np.stack(np.indices(SHAPE), -1) - MIDDLE, axis=-1)


def layers(thickness: float, marrow: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Values around a braincase of radius 25: dark bone, bright scalp 6 thick, air."""
    values = np.zeros(SHAPE, np.float32)
    head = distance < 25 + thickness + 6
    values[head] = 1.6
    values[distance < 25 + thickness] = 0.1
    if marrow:
        values[(distance > 28) & (distance < 25 + thickness - 2.5)] = 0.9
    values[distance < 25] = 1
    return values, head


@pytest.mark.parametrize(("thickness", "marrow"), [(5.0, False), (8.0, False), (11.0, True)])
def test_bone_ends_where_scalp_begins(thickness, marrow):
    values, head = layers(thickness, marrow)
    skull = find_skull(values, head, distance < 25, 1.0, PARAMETERS)
    expected = (distance >= 25) & (distance < 25 + thickness)
    assert 2 * (skull & expected).sum() / (skull.sum() + expected.sum()) > 0.93


def test_where_no_skin_is_near_the_skull_has_its_usual_thickness():
    values = np.ones(SHAPE, np.float32)
    skull = find_skull(values, np.ones(SHAPE, bool), distance < 25, 1.0, PARAMETERS)
    outer = 25 + PARAMETERS.skull_thickness_mm
    assert skull[(distance > 25.5) & (distance < outer - 1)].all()
    assert not skull[distance > outer + 1].any()


def test_a_shell_has_its_thickness_and_leaves_the_inside_free():
    inside = distance < 25
    shell = shell_skull(inside, 6.0, 1.0)
    assert not (shell & inside).any()
    assert shell[(distance > 25) & (distance < 30)].all() and not shell[distance > 31].any()


def test_the_braincase_fills_clefts_and_adds_the_gap():
    brain = (distance < 30) & (abs(np.indices(SHAPE)[0] - 44) > 3)
    case = find_braincase(brain, 1.0, PARAMETERS)
    # At the cleft's rim a ball of the closing's radius still dips in a little.
    assert case[distance < 28].all()
    assert case[(distance < 31) & (abs(np.indices(SHAPE)[0] - 44) > 12)].all()
    assert not case[distance > 30 + PARAMETERS.csf_gap_mm + 0.1].any()


def test_the_base_opens_below_the_brain_stem_and_nowhere_else():
    brain = distance < 24
    skull = shell_skull(distance < 26, 5.0, 1.0)
    left_mm = (np.indices(SHAPE)[0] - MIDDLE[0]).astype(np.float32)
    narrow = PARAMETERS.model_copy(update={"foramen_radius_mm": 8.0})
    opened = open_base(skull, brain, left_mm, 1.0, narrow)
    x, y, z = np.indices(SHAPE)
    from_axis = np.hypot(x - MIDDLE[0], y - MIDDLE[1])
    below = z < MIDDLE[2]
    assert not opened[below & (from_axis < 7)].any()
    rest = ~below | (from_axis > 9.5)
    np.testing.assert_array_equal(opened[rest], skull[rest])
