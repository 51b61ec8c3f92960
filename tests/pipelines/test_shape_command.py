"""`tendril shape` from files on disk to its printed figures, files and page."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

from nodes.errors import BadInput
from pipelines.project import Project
from pipelines.shape_command import NO_SHAPE, compute_shape
from tests.checkout import Checkout
from tests.conftest import ROOT

ROBOTS = ROOT / "catalog" / "robots"


@pytest.fixture(scope="module")
def project(tmp_path_factory) -> Project:
    return Project(Checkout(tmp_path_factory.mktemp("shapes")).root)


def backbone(project: Project, name: str) -> np.ndarray:
    file = project.runs / name / "latest" / "robot_shape" / "backbone.csv"
    rows = list(csv.DictReader(file.read_text("utf-8").splitlines()))
    return np.array([[float(row[f"{axis}_mm"]) for axis in "xyz"] for row in rows])


def test_three_tubes_have_a_shape_a_page_and_files(project: Project, capsys) -> None:
    files = [str(ROBOTS / f"concentric_tubes_three{end}.yml") for end in ("", "_configuration")]
    assert compute_shape(project, *files, "tubes") == 0
    told = capsys.readouterr().out
    assert "concentric tubes: solved" in told and "stability" in told
    assert "viewer3d" in (project.root / "reports" / "tubes.html").read_text("utf-8")
    points = backbone(project, "tubes")
    printed = [
        float(word)
        for word in told.partition("tip  ")[2].partition("[")[2].partition("]")[0].split(",")
    ]
    assert np.linalg.norm(points - printed, axis=1).min() < 1e-6
    assert (project.runs / "tubes" / "latest" / "robot_shape" / "backbone.vtp").stat().st_size


def test_a_loaded_crisp_robot_has_a_shape_with_its_snares_at_the_tool(project, capsys) -> None:
    files = ["crisp_two_snares.yml", "crisp_loaded_configuration.yml"]
    assert compute_shape(project, *(str(ROBOTS / file) for file in files), "crisp") == 0
    told = capsys.readouterr().out
    assert "CRISP: solved" in told and "residual" in told and "energy" in told


def test_a_shape_that_is_fresh_is_not_computed_again(project: Project, capsys) -> None:
    files = [str(ROBOTS / f"concentric_tubes_three{end}.yml") for end in ("", "_configuration")]
    compute_shape(project, *files, "twice")
    runs = list((project.runs / "twice").glob("0*"))
    first = capsys.readouterr().out
    compute_shape(project, *files, "twice")
    again = capsys.readouterr().out
    assert again.startswith("concentric tubes: solved") and first.endswith(again)
    assert list((project.runs / "twice").glob("0*")) == runs


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("lengths_mm: [500, 154, 153]", "lengths_mm: [500, 20, 153]"), "no shorter"),
        (("lengths_mm: [500, 154, 153]", "lengths_mm: [500, -154, 153]"), "-154"),
        (("lengths_mm: [500, 154, 153]", "lengths_mm: [500, 154]"), "3"),
        (("lengths_mm:", "lenght_mm: [1]\nlengths_mm:"), "did you mean lengths_mm"),
    ],
)
def test_an_impossible_configuration_is_refused(
    project: Project, tmp_path: Path, change: tuple[str, str], told: str
) -> None:
    text = (ROBOTS / "crisp_two_snares_configuration.yml").read_text("utf-8")
    assert change[0] in text
    (tmp_path / "c.yml").write_text(text.replace(*change), "utf-8")
    with pytest.raises(BadInput, match=told):
        compute_shape(project, str(ROBOTS / "crisp_two_snares.yml"), str(tmp_path / "c.yml"), "bad")


def test_names_of_cases_folders_and_missing_files_are_refused(project: Project, tmp_path) -> None:
    robot = str(ROBOTS / "crisp_two_snares.yml")
    with pytest.raises(BadInput, match="file of its own"):
        compute_shape(project, robot, robot, "thorax_phantom")
    with pytest.raises(BadInput, match="one YAML file each"):
        compute_shape(project, str(tmp_path), robot, "x")
    shutil.copy(robot, tmp_path / "crisp.yml")
    with pytest.raises(BadInput):  # two robots, no configuration
        compute_shape(project, robot, str(tmp_path / "crisp.yml"), "x")


def test_where_no_shape_exists_the_page_says_so(project: Project, tmp_path: Path, capsys) -> None:
    """A snare that reaches the tool only if the tool were a taut string: refused or not solved."""
    text = (ROBOTS / "crisp_two_snares_configuration.yml").read_text("utf-8")
    (tmp_path / "c.yml").write_text(text.replace("154, 153", "154, 260"), "utf-8")
    code = compute_shape(
        project, str(ROBOTS / "crisp_two_snares.yml"), str(tmp_path / "c.yml"), "strained"
    )
    told = capsys.readouterr().out
    page = (project.root / "reports" / "strained.html").read_text("utf-8")
    assert (code == NO_SHAPE) == ("CRISP: solved" not in told)
    assert ("viewer3d" in page) or ("no solution" in page) or ("not converged" in page)
