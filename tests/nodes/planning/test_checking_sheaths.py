"""Sheaths are as far from bone as closed forms say, whatever the axes of the label map."""

import numpy as np
import pytest

from nodes.errors import BadInput
from nodes.planning.checking_sheaths import find_bone, measure_sheath
from tests.nodes.planning.made_motions import PARAMETERS, bone_map

ENTRY = np.array([[0.0, 0, 0]])
SLAB = ((5, -60, -60), (20, 60, 60))  # bone from x = 5.5 on, by voxels of 1 x 1 x 2 mm


def nearest(tangents, slab=SLAB) -> np.ndarray:
    bone = find_bone(bone_map(slab), ENTRY, PARAMETERS)
    return measure_sheath(ENTRY[0], np.array(tangents, float), 0.51, bone, PARAMETERS).least_mm


def test_a_sheath_beside_a_slab_keeps_its_distance() -> None:
    edge = 5.5
    assert nearest([[0, 0, 1]])[0] == pytest.approx(edge - 0.51, abs=2 * PARAMETERS.accuracy_mm)


def test_a_tilt_brings_the_sheaths_far_end_to_bone() -> None:
    """The sheath goes back: a tangent that leans away from the slab brings it near."""
    lean = 4.0 / PARAMETERS.outside_mm
    way = np.array([-lean, 0, np.sqrt(1 - lean**2)])
    found = nearest([way])[0]
    assert found == pytest.approx(5.5 - 4.0 - 0.51, abs=2 * PARAMETERS.accuracy_mm)
    assert nearest([way * [-1, 1, 1]])[0] > 4.9


def test_turning_between_two_configurations_is_taken_off() -> None:
    ways = np.array([[0.0, 0.3, 1], [0.0, -0.3, 1]])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    bar = ((-30, -1, -30), (30, 1, -20))
    alone = [nearest([way], bar)[0] for way in ways]
    assert min(alone) > 4 and nearest(ways, bar)[0] < 0


def test_beyond_the_sheath_bone_does_not_matter() -> None:
    behind = ((-30, -30, -60), (30, 30, -50))
    assert nearest([[0, 0, 1]], behind)[0] == pytest.approx(50 - 40 - 0.51, abs=1.1)


def test_an_unknown_label_is_refused() -> None:
    with pytest.raises(BadInput, match="sheath_avoids: ribs"):
        find_bone(bone_map(), ENTRY, PARAMETERS.model_copy(update={"sheath_avoids": ("ribs",)}))
