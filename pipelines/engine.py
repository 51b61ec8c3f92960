"""Plans what is stale, loads, calls, saves. Knows no Prefect and prints nothing."""

import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from importlib import import_module
from pathlib import Path
from typing import Any

from catalog.datasets import find_dataset
from catalog.signatures import hash_files, read_files
from catalog.store import Damaged, Record
from nodes.errors import BadInput
from pipelines.account import tell_run
from pipelines.history import History
from pipelines.keys import differences, key_of, made_from
from pipelines.outcomes import CACHED, COMPUTED, FRESH, NEVER_RUN, STALE, WAITING, Outcome, Planned
from pipelines.project import Job, Project
from pipelines.selection import Selection, upstream
from pipelines.stage import ACCOUNT, Stage

Observer = Callable[[str, Stage, Outcome | None], None]


class Run:
    """One run of a job, stage by stage; Prefect and plain Python both drive it.

    Parameters
    ----------
    observe : called with ("computed" | "cached" | "waiting" | "running", stage, outcome or None).
    """

    def __init__(
        self,
        project: Project,
        job: Job,
        selection: Selection = Selection(),  # noqa: B008 - frozen
        observe: Observer = lambda event, stage, outcome: None,
    ) -> None:
        self.project, self.job, self.selection, self.observe = project, job, selection, observe
        self.history = History(project, job.case.name)
        self.chosen = selection.choose(job.stages)
        self.hashes = self._hash_inputs()
        self.started = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
        self.outcomes: dict[str, Outcome] = {}
        self._reasons: dict[str, tuple[str, ...]] = {}
        self._forced = set(selection.forced)

    # Planning

    def plan(self) -> list[Planned]:
        """Return the state of every stage, in order, without computing anything."""
        hashes, plan = dict(self.hashes), []
        for stage in self.job.stages:
            planned = self._plan_stage(stage, hashes, plan)
            plan.append(planned)
            if planned.record:
                hashes |= planned.record.outputs
        self._reasons = {planned.stage.name: planned.reasons for planned in plan}
        self.project.store.signatures.save()
        return plan

    def verify(self) -> None:
        """Read every byte of inputs and artefacts again, whatever the times of files say."""
        signatures = self.project.store.signatures
        for name, path in self.job.inputs.items():
            self.hashes[name] = signatures.hash_path(path, again=True) or ""
        for content in self.history.outputs().values():
            self.project.store.is_intact(content, again=True)

    def _plan_stage(self, stage: Stage, hashes: dict, plan: Sequence[Planned]) -> Planned:
        last = self.history.last_key(stage.name)
        above = upstream(self.job.stages, stage)
        waits = [p.stage.name for p in plan if p.state != FRESH and p.stage.name in above]
        if waits:
            why = f"{waits[-1]} runs before it"
            if stage.name in self._forced:
                why = "asked for with --force"
            return Planned(stage, STALE if last else NEVER_RUN, (why,))
        parts = made_from(self.project, self.job, stage, hashes)
        record = self.project.store.read_record(key_of(parts))
        missing = self._missing_outputs(record) if record else []
        if record and not missing and stage.name not in self._forced:
            return Planned(stage, FRESH, (), record)
        if missing:
            return Planned(stage, STALE, tuple(missing))
        if record:
            return Planned(stage, STALE, ("asked for with --force",))
        return Planned(stage, STALE if last else NEVER_RUN, self._why(stage, last, parts))

    def _missing_outputs(self, record: Record) -> list[str]:
        store = self.project.store
        return [
            f"artefact {name} is " + ("damaged" if store.object_path(content).exists() else "gone")
            for name, content in record.outputs.items()
            if not store.is_intact(content)
        ]

    def _why(self, stage: Stage, last: str, parts: dict) -> tuple[str, ...]:
        if not last:
            return ()
        before = self.project.store.read_record(last)
        if before is None:
            return ("the record of its last run is gone",)
        return tuple(differences(before.made_from, parts, stage.arguments))

    def check_selection(self, plan: Sequence[Planned]) -> list[Stage]:
        """Return the stages to go through: the chosen ones, and what they need, from cache.

        Raises
        ------
        BadInput : if a chosen stage needs one that is stale and not chosen.
        """
        needed = set(self.chosen)
        for stage in self.job.stages:
            if stage.name in self.chosen:
                needed |= upstream(self.job.stages, stage)
        for planned in reversed(plan):
            name = planned.stage.name
            if name in needed - self.chosen and planned.state != FRESH:
                raise BadInput(
                    "; ".join([f"{name} is {planned.state}", *planned.reasons]),
                    "what a chosen stage needs must be fresh or be chosen too",
                    f"run without --only or --from, or first `tendril run --to {name}`",
                )
        return [stage for stage in self.job.stages if stage.name in needed]

    # Running

    def do(self, stage: Stage) -> Outcome:
        """Bring one stage up to date; those before it must be.

        Raises
        ------
        BadInput : for input that a node refuses, or a disk that keeps nothing.
        """
        try:
            outcome = self._serve(stage)
        except Damaged as damage:  # seen only when it was read: the disk lost it, no program did
            self._mend(str(damage.args[0]))
            return self.do(stage)
        self.hashes |= outcome.record.outputs
        self.outcomes[stage.name] = outcome
        self.observe(outcome.status, stage, outcome)
        return outcome

    def _serve(self, stage: Stage) -> Outcome:
        store = self.project.store
        parts = made_from(self.project, self.job, stage, self.hashes)
        key = key_of(parts)
        if stage.name not in self._forced and (record := self._usable(key)):
            return Outcome(stage, CACHED, (), record)
        with store.lock_key(key, lambda: self.observe(WAITING, stage, None)):
            if stage.name not in self._forced and (record := self._usable(key)):
                return Outcome(stage, CACHED, (), record)  # another run did it while we waited
            self.observe("running", stage, None)
            record = self._compute(stage, key, parts)
        self._forced.discard(stage.name)
        return Outcome(stage, COMPUTED, self._why_computed(stage, parts), record)

    def _why_computed(self, stage: Stage, parts: dict) -> tuple[str, ...]:
        """Return what differs from last time; where nothing does, what the plan said."""
        last = self.history.last_key(stage.name)
        return self._why(stage, last, parts) or (self._reasons.get(stage.name, ()) if last else ())

    def _usable(self, key: str) -> Record | None:
        record = self.project.store.read_record(key)
        return record if record and not self._missing_outputs(record) else None

    def _compute(self, stage: Stage, key: str, parts: dict) -> Record:
        started = time.perf_counter()
        values = self._call(stage)
        outputs = {
            name: self.project.store.save_object(
                find_dataset(self.project.catalog, name).load_format().encode(value)
            )
            for name, value in zip(stage.outputs, values, strict=True)
        }
        if not self.project.reader.is_still(stage, parts["code"]):
            raise BadInput(
                f"source was edited while {stage.name} was computed, or since this Python began",
                "a result counts only for the code that made it",
                "run again (in a notebook: restart the kernel)",
            )
        seconds = time.perf_counter() - started
        made_at = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
        record = Record(key, stage.name, parts, outputs, round(seconds, 4), made_at)
        self.project.store.write_record(record)
        return record

    def _call(self, stage: Stage) -> tuple:
        module, _, name = stage.target.partition(":")
        function = getattr(import_module(module), name)
        known = self.project.reader.facts(stage).arguments
        values = {argument: self._load(dataset) for argument, dataset in stage.arguments.items()}
        named = {argument: value for argument, value in values.items() if argument in known}
        more = [value for argument, value in values.items() if argument not in known]
        if stage.name in self.job.parameters:
            named["parameters"] = self.job.parameters[stage.name]
        result = function(*more, **named)
        return result if len(stage.outputs) > 1 else (result,)

    def _load(self, name: str) -> Any:
        if name == ACCOUNT:
            return tell_run(self.project, self.job, self.hashes, self.outcomes, self.started)
        dataset = find_dataset(self.project.catalog, name)
        if name in self.job.absent:
            files = {}
        elif name in self.job.inputs:
            files = read_files(self.job.inputs[name])
            if hash_files(files) != self.hashes[name]:
                raise BadInput(
                    f"input {name} changed while it was read",
                    "an input must hold still during a run",
                    "wait until whatever writes it is done, then run again",
                )
        else:
            files = self.project.store.load_object(self.hashes[name])
        return dataset.load_format().decode(files)

    def keep(self, status: str, error: str = "") -> Path:
        """Note this run in the case's history; return the folder of the note."""
        outcomes = self.outcomes.values()
        return self.history.keep(self.job.case, self.started, outcomes, status, error)

    def _mend(self, content: str) -> None:
        """Make a damaged artefact again by its own stage; others follow only if it came out new."""
        done = [outcome.stage for outcome in self.outcomes.values()]
        makers = [s for s in done if content in self.outcomes[s.name].record.outputs.values()]
        if not makers:
            raise Damaged(content)
        for stage in makers:
            self.do(stage)
        if content not in self.hashes.values():
            for stage in done:
                self.do(stage)

    def _hash_inputs(self) -> dict[str, str]:
        hashes = dict.fromkeys(self.job.absent, hash_files({}))
        for name, path in self.job.inputs.items():
            try:
                content = self.project.store.signatures.hash_path(path)
            except OSError as error:  # without the file's name, which may be a patient's
                raise BadInput(
                    f"input {name} cannot be read: {error.strerror}",
                    "all of a case's files and folders must be readable",
                    "mend their permissions",
                ) from None
            if content is None:
                raise BadInput(
                    f"input {name}: nothing at {path}, or a link in it leads nowhere",
                    "a case's inputs must be files or folders that exist and are not empty",
                    f"mend the path in catalog/cases/{self.job.case.name}.yml",
                )
            hashes[name] = content
        return hashes
