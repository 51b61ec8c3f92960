"""The page that lists all cases."""

from hashlib import sha256
from pathlib import Path

from catalog.memory import recall, remember
from pipelines.history import History, publish
from pipelines.project import Project


def index_path(project: Project) -> Path:
    """Return where the page of all cases stands."""
    return project.root / "reports" / "index.html"


def publish_index(project: Project) -> None:
    """Write reports/index.html from what the newest run of every case tells, if that is news."""
    lines = tuple(_tell_case(project, name) for name in project.cases())
    memory, signatures = project.store.root / "index.json", project.store.signatures
    known = recall(memory)
    told = sha256(repr([lines, project.reader.stamp]).encode()).hexdigest()
    page = signatures.hash_path(index_path(project))
    if page and known.get("told") == told and known.get("page") == page:
        return
    from nodes.reporting.build_index_page import build_index_page

    publish(index_path(project), build_index_page(cases=lines).html.encode("utf-8"))
    page = signatures.hash_path(index_path(project), again=True)
    signatures.save()
    remember(memory, {"told": told, "page": page})


def _tell_case(project: Project, name: str):
    from nodes.errors import BadInput
    from nodes.reporting.artefacts import CaseLine

    told = History(project, name).latest()
    try:
        case = project.case(name)
        title, pipeline, broken = case.title, case.pipeline, ""
    except BadInput as error:  # a case that someone is still writing must not hide the others
        title, pipeline, broken = name, "", error.rule
    pages = [p for p in told.get("published", {}) if (project.root / p).exists()]
    return CaseLine(
        case=name,
        title=title,
        pipeline=pipeline,
        status=told.get("status", "never run"),
        started=told.get("started", ""),
        seconds=told.get("seconds", 0.0),
        page=pages[0].removeprefix("reports/") if pages else "",
        warnings=(broken,) if broken else tuple(told.get("warnings", ())),
    )
