"""Small artefacts whose pictures are known, and the default parameters."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from nodes.geometry.grids import LabelMap, Volume
from nodes.geometry.meshes import Mesh, Surfaces
from nodes.geometry.origin import Origin
from nodes.parameters import Parameters
from nodes.reporting import parameters as kinds
from nodes.reporting.artefacts import ChangedParameter, RunAccount, StageAccount
from nodes.reporting.build_case_page import build_case_page

DEFAULTS = Path(__file__).resolve().parents[3] / "catalog" / "parameters"
HOSTILE = "</script><script>document.title='owned'</script>\"'<b onmouseover=\"x\">&amp;"
KINDS = {
    "show_surfaces": kinds.ShowSurfacesParameters,
    "show_shape": kinds.ShowShapeParameters,
    "show_sites": kinds.ShowSitesParameters,
    "show_entries": kinds.ShowEntriesParameters,
    "show_slices": kinds.ShowSlicesParameters,
    "show_volume": kinds.ShowVolumeParameters,
    "show_measures": kinds.ShowTableParameters,
    "show_plans": kinds.ShowPlansParameters,
    "show_visibility": kinds.ShowVisibilityParameters,
    "show_setups": kinds.ShowSetupsParameters,
    "show_study": kinds.ShowStudyParameters,
    "build_case_page": kinds.BuildCasePageParameters,
}


@pytest.fixture(scope="session")
def hostile() -> str:
    """Text that would run as a script wherever it is not escaped."""
    return HOSTILE


@pytest.fixture(scope="session")
def defaults() -> Callable[..., Parameters]:
    """Give `defaults(stage, **changes)`: the default parameters with some changed."""
    import yaml

    def defaults(stage: str, **changes: object) -> Parameters:
        values = yaml.safe_load((DEFAULTS / f"{stage}.yml").read_text(encoding="utf-8"))
        return KINDS[stage](**(values | changes))

    return defaults


@pytest.fixture(scope="session")
def box_with_ball() -> tuple[Volume, LabelMap]:
    """A box of soft tissue in air with a ball of bone in its left posterior upper part."""
    i, j, k = np.mgrid[:48, :40, :20]
    box = (i > 4) & (i < 43) & (j > 4) & (j < 35)
    ball = (i - 33) ** 2 + (j - 27) ** 2 + (2 * (k - 13)) ** 2 < 36
    hu = np.where(ball, 900, np.where(box, 40, -1000)).astype(np.int16)
    labels = np.where(ball, 2, np.where(box, 1, 0)).astype(np.uint8)
    patient_from_index = np.diag([2.0, 2.0, 4.0, 1.0])
    patient_from_index[:3, 3] = (-48.0, -40.0, 100.0)
    origin = Origin("a box with a ball")
    return (
        Volume(hu, patient_from_index, "HU", origin),
        LabelMap(labels, patient_from_index, ("body", "bone"), origin),
    )


def make_sphere(centre: tuple[float, float, float], radius_mm: float) -> Mesh:
    """Return a sphere of 48 x 24 patches."""
    around, over = np.meshgrid(np.linspace(0, 2 * np.pi, 49), np.linspace(0, np.pi, 25))
    unit = np.stack([np.sin(over) * np.cos(around), np.sin(over) * np.sin(around), np.cos(over)])
    points = unit.reshape(3, -1).T * radius_mm + centre
    first = (np.arange(24)[:, None] * 49 + np.arange(48)).ravel()
    lower, upper = np.stack([first, first + 49, first + 1]), np.stack([1, 49, 50])[:, None] + first
    triangles = np.concatenate([lower.T, upper.T])
    return Mesh(points.astype(np.float32), triangles.astype(np.int32))


@pytest.fixture(scope="session")
def balls() -> Surfaces:
    """A translucent body around a lung on the patient's left and a bone on the right."""
    meshes = (
        ("body", make_sphere((0, 0, 0), 100)),
        ("left_lung", make_sphere((45, 0, 10), 40)),
        ("bone", make_sphere((-50, 0, -10), 25)),
    )
    return Surfaces(meshes, Origin("three balls", True, ("Balls are not anatomy.",)))


def make_stage(
    name: str, inputs: str, outputs: str, status: str = "computed", seconds: float = 1.25
) -> StageAccount:
    """Return a stage with made-up hashes; inputs and outputs are split at spaces."""
    hashes = tuple((name + output).encode().hex().ljust(64, "0")[:64] for output in outputs.split())
    return StageAccount(
        name=name,
        summary=f"Does {name}.",
        inputs=tuple(inputs.split()),
        outputs=tuple(outputs.split()),
        status=status,
        reasons=("never run",) if status == "computed" else (),
        seconds=seconds,
        key=name.encode().hex().ljust(64, "f")[:64],
        output_hashes=hashes,
    )


@pytest.fixture(scope="session")
def run_account() -> RunAccount:
    """A run of the thin path in which the segmentation came from cache."""
    stages = (
        make_stage("read_volume", "ct_files", "ct"),
        make_stage("segment_ct", "ct", "label_map", "cached", 12.0),
        make_stage("build_surfaces", "label_map", "surfaces"),
        make_stage("show_surfaces", "surfaces", "surfaces_section"),
        make_stage("show_slices", "ct label_map", "slices_section"),
        make_stage(
            "build_case_page", "surfaces_section slices_section run_account", "page", "running", 0.0
        ),
    )
    changed = ChangedParameter("segment_ct", "air_hu", "-450", "-400", "Below this is air, in HU.")
    return RunAccount(
        case="two_balls",
        title="Two balls",
        pipeline="anatomy",
        run="7",
        started="2025-01-03 14:02",
        inputs=(("ct_files", "folder of 133 files, 70 MB", "ab" * 32),),
        stages=stages,
        changed_parameters=(changed,),
        versions=(("numpy", "2.4.6"), ("tendril", "0.1.0")),
    )


@pytest.fixture(scope="session")
def case_page(run_account, defaults) -> Callable[..., str]:
    """Give `case_page(*sections)`: the HTML of a case page with these sections."""

    def case_page(*sections, account=run_account):
        parameters = defaults("build_case_page")
        return build_case_page(*sections, run_account=account, parameters=parameters).html

    return case_page


@pytest.fixture
def show(open_page, case_page):
    """Give `show(*sections)`: open a case page with these sections when it is drawn."""

    def show(*sections, width=1200, dark=False, **account):
        page = open_page(case_page(*sections, **account), width=width, dark=dark)
        page.wait_until_ready()
        return page

    return show


@pytest.fixture(scope="session")
def differ() -> Callable[[np.ndarray, np.ndarray], float]:
    """Give `differ(one, other)`: the share of pixels that differ clearly."""

    def differ(one: np.ndarray, other: np.ndarray) -> float:
        return float((np.abs(one.astype(int) - other.astype(int)).max(axis=2) > 12).mean())

    return differ
