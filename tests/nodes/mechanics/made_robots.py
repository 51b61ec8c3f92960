"""Robots of plain numbers that tests change one number of."""

import numpy as np

from nodes.mechanics.robots import (
    ConcentricTubeConfiguration,
    ConcentricTubeRobot,
    CrispConfiguration,
    CrispSetup,
    Material,
    Needle,
    Snare,
    Tube,
)

METAL = Material("other", 60000.0, 0.3, 0.05)


def tube(inner=0.8, outer=1.1, straight=100.0, curved=50.0, curvature=0.02, of=METAL) -> Tube:
    return Tube(of, inner, outer, straight, curved, curvature)


def concentric_tubes(**changed) -> ConcentricTubeRobot:
    tubes = (tube(), tube(1.3, 1.7, 50.0, 35.0, 0.01))
    return ConcentricTubeRobot(**{"tubes": tubes, "patient_from_base": np.eye(4), **changed})


def joints(rotations=(0.3, -1.0), translations=(-40.0, -20.0)) -> ConcentricTubeConfiguration:
    return ConcentricTubeConfiguration(np.array(rotations, float), np.array(translations, float))


def needle(precurvature=(0.0, 0.0, 0.0)) -> Needle:
    return Needle(METAL, 0.97, 1.27, np.array(precurvature, float))


def crisp(**changed) -> CrispSetup:
    """Two snares from the sides on a tool along +z."""
    entries = np.array([[0.0, 0, 0], [100, 0, 80], [0, 100, 120]])
    fields = {
        "needles": (needle(), needle(), needle()),
        "entry_points_patient_mm": entries,
        "snares": (Snare(1, 120.0), Snare(2, 80.0)),
        "field_of_view_deg": 80.0,
    }
    return CrispSetup(**{**fields, **changed})


def poses(lengths=(200.0, 105.0, 105.0), loads=()) -> CrispConfiguration:
    turns = np.repeat(np.eye(3)[None], len(lengths), 0)
    return CrispConfiguration(turns, np.array(lengths, float), loads)
