"""`tendril shape`: a case without a file, of one robot in one configuration."""

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from catalog.cases import Case, check_case_name
from nodes.errors import BadInput
from nodes.mechanics.shapes import RobotShape
from pipelines.console import near, show_progress
from pipelines.history import History
from pipelines.project import Project
from pipelines.running import run_job

NO_SHAPE = 6
"""Exit code where the mechanics found no shape to build on."""

# What a robot file says it is -> heading, pipeline, and the datasets of the two files.
_PIPELINES = {
    "concentric_tubes": (
        "Shape of a concentric tube robot",
        "concentric_tube_shape",
        ("concentric_tube_robot", "concentric_tube_configuration"),
    ),
    "crisp": ("Shape of a CRISP robot", "crisp_shape", ("crisp_setup", "crisp_configuration")),
}


def compute_shape(
    project: Project, robot: str, configuration: str, name: str, settings: Sequence[str] = ()
) -> int:
    """Bring the shape and its page up to date, tell what came out, and return the exit code.

    Raises
    ------
    BadInput : for files that are not there or break a rule, and the name of a case.
    """
    case = _make_case(project, robot, configuration, name)
    with ExitStack() as open_things:
        watch = show_progress(name, open_things)
        run_job(project, project.job_of(case, settings), watch=watch)
    history = History(project, name)
    content = history.outputs()["robot_shape"]
    form = project.catalog["robot_shape"].load_format()
    shape = form.decode(project.store.load_object(content))
    for line in tell_shape(shape):
        print(line)
    folder = near(project.runs / name / "latest" / "robot_shape")
    print(f"  backbone  {folder}/backbone.csv, {folder}/backbone.vtp")
    for page in history.latest()["published"]:
        print(f"  page      {near(project.root / page)}")
    return 0 if shape.status == "solved" else NO_SHAPE


def tell_shape(shape: RobotShape) -> list[str]:
    """Return the lines that say what the mechanics found."""
    lines = [f"{shape.kind}: {shape.status}" + (f", {shape.reason}" if shape.reason else "")]
    if shape.patient_from_tip.size:
        place = ", ".join(f"{value:.6f}" for value in shape.patient_from_tip[:3, 3])
        along = ", ".join(f"{value:.6f}" for value in shape.patient_from_tip[:3, 2])
        lines += [f"  tip          [{place}] mm, patient LPS", f"  tip tangent  [{along}]"]
    width = max((len(figure.name) for figure in shape.figures), default=0)
    for figure in shape.figures:
        value = f"{figure.value:.6g} {figure.unit}".rstrip()
        lines.append(f"  {figure.name:{width}}  {value:14}  {figure.meaning}")
    return lines + [f"  note: {notice}" for notice in shape.origin.notices]


def _make_case(project: Project, robot: str, configuration: str, name: str) -> Case:
    from catalog.formats.robot import robot_kind

    check_case_name(name)
    if name in project.cases():
        raise BadInput(
            f"--name {name}", "a case of that name has a file of its own", "choose another name"
        )
    files = [_existing(written) for written in (robot, configuration)]
    title, pipeline, datasets = _PIPELINES[robot_kind(files[0].read_bytes())]
    inputs = {dataset: str(path) for dataset, path in zip(datasets, files, strict=True)}
    return Case(name=name, title=title, pipeline=pipeline, inputs=inputs)


def _existing(written: str) -> Path:
    path = Path(written).expanduser().resolve()
    if not path.is_file():
        raise BadInput(
            written, "a robot and its configuration are one YAML file each", "mend the path"
        )
    return path
