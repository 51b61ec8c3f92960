"""What a person sees of a run: a bar with time left on a terminal, plain lines elsewhere."""

import sys
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Any

from pipelines.outcomes import Outcome
from pipelines.stage import Stage

# While a stage runs longer than it did last time, its part of the bar stops here.
_ALMOST = 0.95


def expected_seconds(stages: Sequence[Stage], last: Mapping[str, float]) -> dict[str, float]:
    """Return how long each stage may take: as last time, or as the mean of those that are known."""
    known = [last[stage.name] for stage in stages if stage.name in last]
    mean = sum(known) / len(known) if known else 1.0
    return {stage.name: last.get(stage.name, mean) for stage in stages}


class Progress(AbstractContextManager):
    """Shows a run of the given stages; `observe` is the engine's observer."""

    def __init__(self, case: str, stages: Sequence[Stage], expected: Mapping[str, float]) -> None:
        self.case, self.expected = case, dict(expected)
        self.total = len(stages)
        self.done = 0
        self._finished = 0.0
        self._now: tuple[str, float] | None = None
        self._stop = threading.Event()
        self._bar: Any = None
        self._lock = threading.Lock()

    def __enter__(self) -> "Progress":
        if sys.stdout.isatty():
            self._start_bar()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stop.set()
        if self._bar:
            self._bar.stop()

    def observe(self, event: str, stage: Stage, outcome: Outcome | None) -> None:
        """Take note of what the engine did."""
        with self._lock:
            if event == "running":
                self._now = (stage.name, time.monotonic())
            elif event == "waiting":
                self._say(f"  {stage.name}: another run computes it, waiting")
            elif outcome:
                self._end(stage, outcome)

    def _end(self, stage: Stage, outcome: Outcome) -> None:
        self.done += 1
        self._now = None
        self._finished += self.expected.get(stage.name, 0.0)
        took = f"{outcome.record.seconds:.2f} s" if outcome.status == "computed" else "from cache"
        why = f"  ({'; '.join(outcome.reasons[:2])})" if outcome.reasons else ""
        self._say(f"  [{self.done}/{self.total}] {stage.name}  {took}{why}")

    def _say(self, line: str) -> None:
        if self._bar:
            self._bar.console.print(line, markup=False, highlight=False)
        else:
            print(line, flush=True)

    def left_seconds(self) -> float:
        """Return the expected time to the end of the run."""
        return max(sum(self.expected.values()) - self._seconds_gone(), 0.0)

    def _seconds_gone(self) -> float:
        if not self._now:
            return self._finished
        name, began = self._now
        share = min(time.monotonic() - began, _ALMOST * self.expected.get(name, 0.0))
        return self._finished + share

    def _start_bar(self) -> None:
        from rich.progress import BarColumn, TextColumn
        from rich.progress import Progress as Bar

        columns = TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[left]}")
        self._bar = Bar(*columns, transient=True)
        task = self._bar.add_task(self.case, total=sum(self.expected.values()) or 1.0, left="")
        self._bar.start()
        threading.Thread(target=self._refresh, args=(task,), daemon=True).start()

    def _refresh(self, task: Any) -> None:
        while not self._stop.wait(0.2):
            doing = self._now[0] if self._now else "from cache" if self.done else "starting"
            left = f"{self.done}/{self.total} stages, about {self.left_seconds():.0f} s left"
            description = f"{self.case}: {doing}"
            gone = self._seconds_gone()
            self._bar.update(task, completed=gone, description=description, left=left)
