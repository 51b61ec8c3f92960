"""What `tendril list` tells."""

from collections.abc import Callable, Iterator

from nodes.errors import BadInput
from pipelines.project import Project
from pipelines.registry import PIPELINES


def _pipelines(project: Project) -> Iterator[str]:
    for name, module in PIPELINES.items():
        yield f"{name:16}  {(module.__doc__ or '').partition(chr(10))[0]}"


def _stages(project: Project) -> Iterator[str]:
    for name, module in PIPELINES.items():
        yield name
        for stage in module.STAGES:
            arrow = f"{', '.join(stage.inputs) or '-'} -> {', '.join(stage.outputs)}"
            yield f"  {stage.name:22}  {arrow}"


def _datasets(project: Project) -> Iterator[str]:
    for name, dataset in project.catalog.items():
        yield f"{name:18}  {dataset.format or '-':12}  {dataset.place:20}  {dataset.about}"


def _cases(project: Project) -> Iterator[str]:
    for name in project.cases():
        try:
            case = project.case(name)
            here = "" if project.is_ready(name) else "  (inputs not on this machine)"
            yield f"{name:18}  {case.pipeline:16}  {case.title}{here}"
        except BadInput as error:
            yield f"{name:18}  refused: {error.value}"


LISTS: dict[str, Callable[[Project], Iterator[str]]] = {
    "pipelines": _pipelines,
    "stages": _stages,
    "datasets": _datasets,
    "cases": _cases,
}
