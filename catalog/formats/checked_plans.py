"""Motions with their verdicts: only what passed the check is called a plan, in every file."""

import json
from collections.abc import Mapping
from dataclasses import asdict

from catalog.formats.motion_files import write_motion
from catalog.formats.motion_plans import (
    SetupFiles,
    files_after,
    read_plan,
    read_setups,
    tell_briefly,
    tell_plan,
)
from catalog.formats.plain_values import (
    COMPUTED,
    FRAME,
    plain_figures,
    read_figures,
    read_origin,
    to_json,
)
from nodes.planning.artefacts import CheckedPlan, CheckedPlans

_LIST = "plans.json"
_COLUMNS = ("clearance_mm", "stability_margin")
PASSED = "plan that passed the independent check"
REFUSED = "refused, not a plan"


class CheckedPlansFormat:
    """Of each plan `plan_1_motion.csv`, `..._needles.vtp`, `..._tip_path.mrk.json` and
    `..._verdict.json`; of what was refused `refused_not_a_plan_1_...`; `plans.json`, `setups/`.
    """

    @staticmethod
    def encode(value: CheckedPlans) -> dict[str, bytes]:
        """Return all files; what has no motion has a verdict alone."""
        setups = SetupFiles([each.proposed for each in value.plans], value.origin)
        files, listed = {}, []
        for number, each in enumerate(value.plans, start=1):
            prefix = _prefix(number, each)
            made = _write(each, setups, "; ".join(tell_briefly(value.origin)))
            files |= {prefix + name: content for name, content in made.items()}
            listed.append(prefix)
        told = {"files": listed, "origin": asdict(value.origin)}
        return {**files, **setups.encode(), _LIST: to_json(told)}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> CheckedPlans:
        """Return the plans of `encode`, equal in every field."""
        told, setups = json.loads(files[_LIST]), read_setups(files)
        plans = []
        for prefix in told["files"]:
            own = files_after(prefix, files)
            verdict = json.loads(own["verdict.json"])
            proposed, columns = read_plan(verdict, own, setups, _COLUMNS)
            plans.append(
                CheckedPlan(
                    proposed,
                    verdict["passed"],
                    tuple(verdict["failures"]),
                    read_figures(verdict["check"]),
                    *columns,
                )
            )
        return CheckedPlans(tuple(plans), read_origin(told["origin"]))


def _prefix(number: int, plan: CheckedPlan) -> str:
    if plan.passed:
        return f"plan_{number}_"
    return f"refused_not_a_plan_{number}_" if _has_motion(plan) else f"no_plan_{number}_"


def _has_motion(plan: CheckedPlan) -> bool:
    return len(plan.proposed.motion.lengths_mm) > 0


def _write(plan: CheckedPlan, setups: SetupFiles, note: str) -> dict[str, bytes]:
    proposed = plan.proposed
    verdict = PASSED if plan.passed else REFUSED if _has_motion(plan) else "no motion was found"
    note = f"{verdict}; {note}"
    columns = dict(zip(_COLUMNS, (plan.clearances_mm, plan.margins), strict=True))
    told = {
        "frame": FRAME,
        "note": COMPUTED,
        "verdict": verdict,
        "passed": plan.passed,
        "failures": plan.failures,
        "check": plain_figures(plan.figures),
        **tell_plan(proposed, setups),
    }
    made = write_motion(proposed.motion, proposed.placed, columns, note)
    return {**made, "verdict.json": to_json(told)}
