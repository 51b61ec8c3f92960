"""Solids of the person's hand, held against a loop over all voxels."""

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from nodes.errors import BadInput
from nodes.imaging.ct_parameters import Correction, Solid
from nodes.imaging.hand_corrections import barrier_mask, paint_corrections

SHAPE = (12, 10, 8)
TURN = np.array([[0, -1.5, 0, 7.0], [2.0, 0, 0.3, -9.0], [0, 0, 2.5, 3.0], [0, 0, 0, 1]])
SOLID = TypeAdapter(Solid)
BALL = {"shape": "ball", "centre_patient_mm": (0, 0, 12), "radius_mm": 5.0}
BOX = {"shape": "box", "lowest_patient_mm": (-4, -5, 5), "highest_patient_mm": (3, 6, 14)}
DISC = {
    "shape": "disc",
    "centre_patient_mm": (0, 0, 12),
    "normal_patient": (1, 1, 0),
    "radius_mm": 7.0,
    "thickness_mm": 4.0,
}


def is_inside(solid, point):
    if solid["shape"] == "box":
        ends = zip(solid["lowest_patient_mm"], point, solid["highest_patient_mm"], strict=True)
        return all(low <= p <= high for low, p, high in ends)
    offset = point - np.array(solid["centre_patient_mm"])
    if solid["shape"] == "ball":
        return np.linalg.norm(offset) <= solid["radius_mm"]
    normal = np.array(solid["normal_patient"]) / np.linalg.norm(solid["normal_patient"])
    across = np.linalg.norm(np.cross(offset, normal))
    return abs(offset @ normal) <= solid["thickness_mm"] / 2 and across <= solid["radius_mm"]


@pytest.mark.parametrize("solid", [BALL, BOX, DISC], ids=lambda solid: solid["shape"])
def test_solids_hold_the_voxels_whose_centres_are_inside(solid):
    mask = barrier_mask(SHAPE, TURN, (SOLID.validate_python(solid),))
    assert mask.any()
    for index in np.ndindex(SHAPE):
        assert mask[index] == is_inside(solid, (TURN @ (*index, 1))[:3])


def test_a_barrier_outside_of_the_image_is_refused():
    far = SOLID.validate_python({**BALL, "centre_patient_mm": (500, 0, 0)})
    with pytest.raises(BadInput, match=r"barrier 1: ball from \[495"):
        barrier_mask(SHAPE, TURN, (far,))


def test_a_correction_of_an_unknown_label_is_refused():
    correction = Correction(label="lung", within=BALL)
    with pytest.raises(BadInput, match="label lung"):
        paint_corrections(np.zeros(SHAPE, np.uint8), TURN, ("body", "bone"), (correction,))


@pytest.mark.parametrize("radius", [0, -3, float("nan"), float("inf")])
def test_a_radius_that_is_none_is_refused(radius):
    with pytest.raises(ValidationError):
        SOLID.validate_python({**BALL, "radius_mm": radius})
