"""Which stages of a pipeline a person asked for."""

from collections.abc import Sequence
from dataclasses import dataclass

from nodes.errors import BadInput
from pipelines.project import find_stage
from pipelines.stage import ACCOUNT, Stage


@dataclass(frozen=True)
class Selection:
    """As on the command line: from a stage on, up to a stage, one alone; and what is made anew.

    `first` and `last` may both be given; `only` stands alone. `forced` names stages that are
    computed even where they are fresh.
    """

    first: str = ""
    last: str = ""
    only: str = ""
    forced: tuple[str, ...] = ()

    def choose(self, stages: Sequence[Stage]) -> set[str]:
        """Return the names of the chosen stages.

        Raises
        ------
        BadInput : for a name that is no stage of the pipeline, or where nothing is chosen.
        """
        chosen = self._choose(stages)
        for name in self.forced:
            if find_stage(stages, name).name not in chosen:
                raise BadInput(
                    f"--force {name}",
                    "a stage that is computed anew must be chosen",
                    f"choose it too, for instance with --from {name}",
                )
        return chosen

    def _choose(self, stages: Sequence[Stage]) -> set[str]:
        if self.only and (self.first or self.last):
            raise BadInput(
                f"--only {self.only} with --from or --to",
                "--only stands alone",
                "leave one of them out",
            )
        if self.only:
            return {find_stage(stages, self.only).name}
        chosen = {stage.name for stage in stages}
        if self.first:
            chosen &= _downstream(stages, find_stage(stages, self.first))
        if self.last:
            chosen &= upstream(stages, find_stage(stages, self.last)) | {self.last}
        if not chosen:
            raise BadInput(
                f"no stage from {self.first} to {self.last}",
                f"{self.last} must need {self.first}",
                "see the pipeline's picture for what needs what",
            )
        return chosen


def upstream(stages: Sequence[Stage], stage: Stage) -> set[str]:
    """Return the names of all stages whose outputs a stage needs, near and far."""
    wanted, names = set(stage.inputs), set()
    for other in reversed(stages[: stages.index(stage)]):
        if ACCOUNT in wanted or wanted & set(other.outputs):
            names.add(other.name)
            wanted |= set(other.inputs)
    return names


def _downstream(stages: Sequence[Stage], stage: Stage) -> set[str]:
    made, names = set(stage.outputs), {stage.name}
    for other in stages[stages.index(stage) + 1 :]:
        if ACCOUNT in other.inputs or made & set(other.inputs):
            names.add(other.name)
            made |= set(other.outputs)
    return names
