"""Motions to goals as a planner found them; not checked, and therefore not called plans."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from catalog.formats.motion_files import read_motion, write_motion
from catalog.formats.placed_setups import PlacedSetupsFormat
from catalog.formats.plain_values import (
    COMPUTED,
    FRAME,
    plain_figures,
    read_figures,
    read_origin,
    to_json,
)
from nodes.geometry.origin import Origin
from nodes.planning.artefacts import MotionPlan, MotionPlans, PlacedSetup, PlacedSetups

_LIST = "motions.json"
_SETUPS = "setups/"
NOT_CHECKED = "proposed, not checked"


class MotionPlansFormat:
    """`proposed_not_checked_1_motion.csv` and so on, `motions.json`, and `setups/`."""

    @staticmethod
    def encode(value: MotionPlans) -> dict[str, bytes]:
        """Return all files; what was not found stands in `motions.json` alone."""
        files = {}
        for number, plan in enumerate(value.plans, start=1):
            note = "; ".join([NOT_CHECKED, *tell_briefly(value.origin)])
            prefix = f"proposed_not_checked_{number}_"
            made = write_motion(plan.motion, plan.placed, {}, note)
            files |= {prefix + name: content for name, content in made.items()}
        setups = SetupFiles(value.plans, value.origin)
        told = {
            "frame": FRAME,
            "note": f"{COMPUTED}; {NOT_CHECKED}",
            "motions": [tell_plan(plan, setups) for plan in value.plans],
            "origin": asdict(value.origin),
        }
        return {**files, **setups.encode(), _LIST: to_json(told)}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> MotionPlans:
        """Return the motions of `encode`, equal in every field."""
        told, setups = json.loads(files[_LIST]), read_setups(files)
        plans = []
        for number, each in enumerate(told["motions"], start=1):
            own = files_after(f"proposed_not_checked_{number}_", files)
            plans.append(read_plan(each, own, setups)[0])
        return MotionPlans(tuple(plans), read_origin(told["origin"]))


class SetupFiles:
    """The setups of plans, each once."""

    def __init__(self, plans: Iterable[MotionPlan], origin: Origin) -> None:
        self.origin = origin
        self.setups: list[PlacedSetup] = []
        self.contents: list[tuple[str, bytes]] = []
        self.origins: dict[int, int] = {}
        for plan in plans:
            self.place_of(plan.placed)

    def place_of(self, placed: PlacedSetup) -> int:
        """Return which of the setups this is, as a whole number from 0."""
        if id(placed) not in self.origins:
            alone = PlacedSetupsFormat.encode(PlacedSetups((placed,), self.origin))
            content = (placed.name, alone["setup_1.yml"])
            if content not in self.contents:
                self.contents.append(content)
                self.setups.append(placed)
            self.origins[id(placed)] = self.contents.index(content)
        return self.origins[id(placed)]

    def encode(self) -> dict[str, bytes]:
        """Return their files."""
        made = PlacedSetupsFormat.encode(PlacedSetups(tuple(self.setups), self.origin))
        return {_SETUPS + name: content for name, content in made.items()}


def read_setups(files: Mapping[str, bytes]) -> tuple[PlacedSetup, ...]:
    """Return the setups of `SetupFiles`."""
    return PlacedSetupsFormat.decode(files_after(_SETUPS, files)).setups


def files_after(prefix: str, files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the files whose names begin so, without that beginning."""
    return {k.removeprefix(prefix): v for k, v in files.items() if k.startswith(prefix)}


def tell_briefly(origin: Origin) -> list[str]:
    """Return what stands in every file of a motion."""
    return [COMPUTED, "simulated anatomy"] if origin.simulated else [COMPUTED]


def tell_plan(plan: MotionPlan, setups: SetupFiles) -> dict[str, Any]:
    """Return what JSON holds of a plan: all but its motion."""
    return {
        "goal": plan.goal,
        "goal_point_patient_mm": plan.goal_point_patient_mm.tolist(),
        "status": plan.status,
        "reason": plan.reason,
        "setup": setups.place_of(plan.placed) + 1,
        "figures": plain_figures(plan.figures),
        "cells": plan.cells.tolist(),
    }


def read_plan(
    told: Mapping[str, Any],
    files: Mapping[str, bytes],
    setups: tuple[PlacedSetup, ...],
    columns: tuple[str, ...] = (),
) -> tuple[MotionPlan, list[np.ndarray]]:
    """Return the plan of `tell_plan` and of its motion's files, and the table's further columns."""
    placed = setups[told["setup"] - 1]
    motion, found = read_motion(files, len(placed.setup.needles), columns)
    plan = MotionPlan(
        goal=told["goal"],
        goal_point_patient_mm=np.array(told["goal_point_patient_mm"], float),
        cells=np.array(told["cells"], np.int64).reshape(-1, 3),
        placed=placed,
        status=told["status"],
        reason=told["reason"],
        motion=motion,
        figures=read_figures(told["figures"]),
    )
    return plan, found
