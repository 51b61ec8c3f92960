"""Every public case from its files to its page; labels of their own, frames."""

import os
from pathlib import Path

import pytest
import SimpleITK as sitk

from tests.checkout import Checkout

ALL = os.environ.get("TENDRIL_ALL_CASES")  # minutes more, of what benchmarks run, too


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Checkout:
    return Checkout(tmp_path_factory.mktemp("checkout") / "tendril")


def test_a_chest_ct_runs_to_two_lungs_an_airway_and_a_page(
    checkout: Checkout, test_data: Path, open_page
) -> None:
    """P002, of four times the voxels, runs in the benchmark."""
    case = "chest_normal001"
    checkout.call("run", "--no-prefect", "--case", case)
    rows = checkout.table(case, "label_table")
    assert 2500 < rows["lungs"]["volume_ml"] < 7000
    assert rows["left_lung"]["parts"] == rows["right_lung"]["parts"] == rows["airway"]["parts"] == 1
    assert 20 < rows["airway"]["volume_ml"] < 200
    open_page(checkout.root / "reports" / f"{case}.html").assert_quiet()


def test_a_lung_collapsed_by_simulation_is_called_simulated(
    checkout: Checkout, test_data: Path, open_page
) -> None:
    chest = str(test_data / "chest_ct" / "normal001_half.nii.gz")
    checkout.call("new-case", "collapsed", "--ct", chest, "--pipeline", "collapsed_lung")
    checkout.call("run", "--no-prefect", "--case", "collapsed")
    latest = checkout.latest("collapsed")

    def header(name: str) -> bytes:
        return (latest / name).read_bytes()[:20000]

    for name in ("label_map.seg.nrrd", "occupancy_grid.seg.nrrd", "ct.nrrd"):
        assert b'"simulated": true' in header(name)
    assert b'"simulated": false' in header("scanned_ct.nrrd")
    rows = checkout.table("collapsed", "label_table")
    assert rows["pleural_cavity"]["volume_ml"] > 500 and rows["pleural_cavity"]["parts"] == 1
    page = checkout.root / "reports" / "collapsed.html"
    assert "Parts of this page are simulated" in page.read_text()
    open_page(page).assert_quiet()


@pytest.mark.parametrize(
    "case",
    [
        "mni152",
        *[
            pytest.param(name, marks=pytest.mark.skipif(not ALL, reason="set TENDRIL_ALL_CASES=1"))
            for name in ("head_ct_straight", "head_ct_tilted", "head_mri", "med_rad_lung1")
        ],
    ],
)
def test_heads_and_handed_in_labels_run_to_a_page(
    checkout: Checkout, test_data: Path, open_page, case: str
) -> None:
    checkout.call("run", "--no-prefect", "--case", case)
    open_page(checkout.root / "reports" / f"{case}.html").assert_quiet()


def test_frames_run_to_a_page(checkout: Checkout, test_data: Path, open_page) -> None:
    checkout.call("new-case", "nose", "--frames", str(test_data / "endoscopy_sinus"))
    checkout.call("run", "--no-prefect", "--case", "nose")
    open_page(checkout.root / "reports" / "nose.html").assert_quiet()


def test_labels_handed_in_replace_what_would_be_found(checkout: Checkout, test_data: Path) -> None:
    """A chest CT with the person's own airway: a ball, which nobody would find."""
    drawn = checkout.root / "data" / "raw" / "drawn"
    drawn.mkdir(parents=True)
    image = sitk.ReadImage(str(test_data / "chest_ct/normal001_half.nii.gz"))
    middle = [n / 2 for n in image.GetSize()]
    place = image.TransformContinuousIndexToPhysicalPoint(middle)
    source = sitk.Image(image.GetSize(), sitk.sitkFloat32)
    source.CopyInformation(image)
    grid = sitk.PhysicalPointSource(
        sitk.sitkVectorFloat32,
        *[image.GetSize(), image.GetOrigin(), image.GetSpacing(), image.GetDirection()],
    )
    axes = [sitk.VectorIndexSelectionCast(grid, n) - place[n] for n in range(3)]
    ball = axes[0] ** 2 + axes[1] ** 2 + axes[2] ** 2 < 15**2
    sitk.WriteImage(ball, str(drawn / "airway.nii.gz"))
    checkout.call("new-case", "given", "--ct", str(test_data / "chest_ct/normal001_half.nii.gz"),
                  "--labels", str(drawn))  # fmt: skip
    checkout.call("run", "--no-prefect", "--case", "given", "--to", "segment_ct")
    found = sitk.ReadImage(str(checkout.latest("given") / "label_map.seg.nrrd"))
    number = next(
        int(found.GetMetaData(f"Segment{n}_LabelValue"))
        for n in range(6)
        if found.GetMetaData(f"Segment{n}_Name") == "airway"
    )
    same = sitk.GetArrayFromImage(found == number) == sitk.GetArrayFromImage(ball)
    assert same.all()
