"""Reference solutions of concentric tubes, and robots made from them."""

import json
from functools import cache
from pathlib import Path

import numpy as np

from nodes.mechanics.robots import (
    ConcentricTubeConfiguration,
    ConcentricTubeRobot,
    Material,
    Tube,
)

PUBLISHED = Path(__file__).resolve().parents[2] / "published"


@cache
def reference_cases():
    return json.loads((PUBLISHED / "ctr_cases.json").read_text())["cases"]


def reference_robot(case, base=None):
    tubes = tuple(
        Tube(
            Material("other", tube["E"], tube["nu"], 0.1),
            tube["ID"],
            tube["OD"],
            tube["Ls"],
            tube["Lc"],
            tube["kappa"],
        )
        for tube in case["tubes"]
    )
    return ConcentricTubeRobot(tubes, np.eye(4) if base is None else base)


def reference_joints(case):
    return joint_values(case["theta"], case["beta"])


def joint_values(rotations, translations):
    return ConcentricTubeConfiguration(np.array(rotations, float), np.array(translations, float))


def tubes_of(*tubes, thick=0.4):
    """Return a robot of (straight, curved, curvature), innermost first, of one material."""
    metal = Material("other", 60000.0, 0.3, 0.2)
    made = tuple(
        Tube(metal, 0.5 + 0.5 * n, 0.5 + 0.5 * n + thick, *tube) for n, tube in enumerate(tubes)
    )
    return ConcentricTubeRobot(made, np.eye(4))


def equal_tubes(*tubes):
    """Return a robot of tubes of the same stiffness, though they nest."""
    made = []
    inner = 0.5
    for straight, curved, curvature in tubes:
        outer = inner + 0.4
        shape = np.pi / 64 * (outer**4 - inner**4)
        metal = Material("other", 1000.0 / shape, 0.3, 0.2)
        made.append(Tube(metal, inner, outer, straight, curved, curvature))
        inner = outer + 0.1
    return ConcentricTubeRobot(tuple(made), np.eye(4))


def random_joints(chance, robot, count):
    """Return rotations and translations (count, tube) with bases and tips in order."""
    lengths = np.array([tube.length_mm for tube in robot.tubes])
    translations = np.zeros((count, len(lengths)))
    high, low = np.zeros(count), np.full(count, -lengths[-1])
    for tube in range(len(lengths) - 1, -1, -1):
        translations[:, tube] = low + (high - low) * chance.random(count)
        high = translations[:, tube]
        low = high + lengths[tube] - lengths[tube - 1]
    return chance.uniform(-np.pi, np.pi, translations.shape), translations
