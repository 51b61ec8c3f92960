"""The published CRISP configurations as setups and configurations."""

import json
from pathlib import Path

import numpy as np

from nodes.mechanics.parameters import ShapeCrispParameters
from nodes.mechanics.robots import (
    CrispConfiguration,
    CrispSetup,
    Material,
    Needle,
    PointLoad,
    Snare,
)

PLACE = Path(__file__).resolve().parents[2] / "published" / "crisp_cases.json"
CASES = {case["name"]: case for case in json.loads(PLACE.read_text())["cases"]}


def parameters(**changed) -> ShapeCrispParameters:
    fields = {
        "tolerance_mm": 1e-9,
        "sample_spacing_mm": 10.0,
        "guesses": 8,
        "seed": 0,
        "same_equilibrium": 1e-5,
        "margin_accuracy": 1e-8,
    }
    return ShapeCrispParameters(**{**fields, **changed})


def case_robot(case, measured_from="entry") -> tuple[CrispSetup, CrispConfiguration]:
    """Return a published case; grasps measured from where is asked for."""
    needles = tuple(
        Needle(
            Material("nitinol", tube["E"], tube["nu"], 0.06),
            tube["ID"],
            tube["OD"],
            np.array(tube["uhat"], float),
        )
        for tube in case["tubes"]
    )
    length = case["lengths"][0]
    snares = tuple(
        Snare(
            joint["snare"],
            joint["s"] if measured_from == "entry" else length - joint["s"],
            measured_from,
            joint["type"],
            joint["d"],
        )
        for joint in case["joints"]
    )
    loads = tuple(
        PointLoad(load["s"], np.array(load["F"], float), np.array(load["T"], float))
        for load in case["loads"]
    )
    setup = CrispSetup(needles, np.array(case["base_p"], float), snares, 80.0)
    rotations = np.array(case["base_R"], float)
    return setup, CrispConfiguration(rotations, np.array(case["lengths"], float), loads)


def case_wrenches(case) -> np.ndarray:
    """Return (n, 6) base wrenches."""
    return np.hstack([np.array(case["out"]["base_m"]), np.array(case["out"]["base_n"])])


def column(force, length=150.0, stiffness_mpa=50000.0) -> tuple[CrispSetup, CrispConfiguration]:
    """Return a tool along z whose tip a force pulls, in units of E I / length^2."""
    needle = Needle(Material("nitinol", stiffness_mpa, 0.33, 0.06), 0.97, 1.27, np.zeros(3))
    bending = stiffness_mpa * np.pi / 64 * (1.27**4 - 0.97**4)
    load = PointLoad(length, np.array(force) * bending / length**2, np.zeros(3))
    setup = CrispSetup((needle,), np.zeros((1, 3)), (), 80.0)
    return setup, CrispConfiguration(np.eye(3)[None], np.array([length]), (load,))
