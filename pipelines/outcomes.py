"""What a plan and a run say of each stage."""

from dataclasses import dataclass

from catalog.store import Record
from pipelines.stage import Stage

FRESH, STALE, NEVER_RUN = "fresh", "stale", "never run"
COMPUTED, CACHED, WAITING = "computed", "cached", "waiting"


@dataclass(frozen=True)
class Planned:
    """What a plan says of one stage: its state, why, and the record that serves it if fresh."""

    stage: Stage
    state: str
    reasons: tuple[str, ...] = ()
    record: Record | None = None


@dataclass(frozen=True)
class Outcome:
    """What a run did with one stage: `status` is "computed" or "cached"."""

    stage: Stage
    status: str
    reasons: tuple[str, ...]
    record: Record
