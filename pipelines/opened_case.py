"""A case in Python and notebooks: load any artefact, call any node by hand, run without Prefect."""

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from catalog.datasets import find_dataset
from catalog.signatures import read_files
from catalog.validation import unknown
from nodes.errors import BadInput
from pipelines.engine import Run
from pipelines.history import History
from pipelines.outcomes import Planned
from pipelines.project import Project, find_stage
from pipelines.running import CaseRun, run_case
from pipelines.selection import Selection


class OpenedCase:
    """One case of a project.

    Parameters
    ----------
    settings : `key=value` on top of the case's own parameters, as after `--set`.
    """

    def __init__(self, project: Project, name: str, settings: Sequence[str] = ()) -> None:
        self.project, self.name, self.settings = project, name, tuple(settings)
        self.job = project.job(name, settings)

    def run(
        self, *, first: str = "", last: str = "", only: str = "", force: Sequence[str] = ()
    ) -> CaseRun:
        """Bring the case up to date in plain Python; the arguments are those of `tendril run`."""
        selection = Selection(first, last, only, tuple(force))
        return run_case(self.project, self.name, self.settings, selection)

    def status(self) -> list[Planned]:
        """Return of each stage whether it is fresh, stale and why, or never ran."""
        return Run(self.project, self.job).plan()

    def load(self, dataset: str) -> Any:
        """Return an input of the case, or an artefact as its newest run made it.

        Raises
        ------
        BadInput : if there is no such dataset, or no run made it yet.
        """
        form = find_dataset(self.project.catalog, dataset).load_format
        if dataset in self.job.absent:
            return form().decode({})
        if dataset in self.job.inputs:
            return form().decode(read_files(self.job.inputs[dataset]))
        return form().decode(self.project.store.load_object(self._content(dataset)))

    def path(self, dataset: str) -> Path:
        """Return the folder that holds an artefact's files, for other programs to open."""
        return self.project.store.object_path(self._content(dataset))

    def parameters(self, stage: str) -> BaseModel:
        """Return the parameters that a stage has in this case."""
        if stage not in self.job.parameters:
            raise unknown("stage with parameters", stage, self.job.parameters)
        return self.job.parameters[stage]

    def node(self, stage: str) -> Callable:
        """Return the function of a stage, to be called by hand."""
        module, _, name = find_stage(self.job.stages, stage).target.partition(":")
        return getattr(import_module(module), name)

    def _content(self, dataset: str) -> str:
        made = History(self.project, self.name).outputs()
        if dataset not in made:
            raise BadInput(
                f"{dataset} of case {self.name}",
                "an artefact can be loaded once a run has made it",
                f"made so far: {', '.join(made) or 'nothing'}; run the case first",
            )
        return made[dataset]
