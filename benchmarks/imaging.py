"""How exact is the anatomy, and what does it cost?

Ten random phantoms against their truth; public scans against what anatomy allows, each run from its
files to its page as a person runs it (needs TENDRIL_TEST_DATA); time and memory against the number
of voxels; and the distance field against SciPy's transform in the same run.

    python -m benchmarks.imaging [--phantoms 10] [--only phantoms real sizes distance]
"""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.case_measures import (
    measure_chest,
    measure_collapse,
    measure_head,
    measure_nothing,
    measure_sites,
)
from benchmarks.tilted_heads import bone_ratio, lay_together
from nodes.environment.measure_distance import measure_distance
from nodes.geometry.grids import LabelMap, Volume, spacing_mm
from nodes.geometry.origin import Origin
from nodes.imaging.make_thorax_phantom import make_thorax_phantom
from nodes.imaging.read_volume import read_volume
from nodes.imaging.score_segmentation import score_segmentation
from nodes.imaging.segment_ct import segment_ct
from pipelines.opened_case import OpenedCase
from pipelines.project import Project

ROOT = Path(__file__).resolve().parent.parent
GOALS = {"lungs": 0.97, "effusion": 0.97, "bone": 0.95, "airway": 0.90}


def random_settings(seed: int) -> list[str]:
    """Return one random patient and scanner: size, disease, noise, spacing."""
    chance = np.random.default_rng(1000 + seed)
    values = {
        "chest_width_mm": chance.uniform(290, 410),
        "effusion_share": chance.uniform(0.15, 0.6),
        "noise_sd_hu": chance.uniform(5, 25),
        "pixel_spacing_mm": chance.uniform(0.8, 1.5),
        "slice_thickness_mm": chance.uniform(1.0, 3.0),
        "variation": chance.uniform(0, 1),
        "adhesions": chance.integers(0, 5),
    }
    settings = [f"make_thorax_phantom.{name}={value:.3g}" for name, value in values.items()]
    return [*settings, f"make_thorax_phantom.seed={seed}"]


def score_phantom(seed: int) -> dict[str, float]:
    """Make, read, segment and score one phantom."""
    settings = random_settings(seed)
    job = Project().job("thorax_phantom", settings)
    files, truth = make_thorax_phantom(job.parameters["make_thorax_phantom"])
    ct = read_volume(files, job.parameters["read_volume"])
    started = time.perf_counter()
    label_map = segment_ct(ct, nothing_given(ct), job.parameters["segment_ct"])
    seconds = time.perf_counter() - started
    table = score_segmentation(label_map, truth).set_index("label")
    row = {f"dice_{name}": float(table.dice[name]) for name in GOALS}
    cavity = table.loc["effusion"]
    row["cavity_error_percent"] = float(100 * (cavity.volume_ml / cavity.truth_volume_ml - 1))
    return row | {"seconds": seconds, "mvoxels": ct.voxels.size / 1e6, "seed": seed}


def nothing_given(ct: Any) -> LabelMap:
    return LabelMap(np.zeros(ct.voxels.shape, np.uint8), ct.patient_from_index, (), ct.origin)


@contextmanager
def fresh_checkout() -> Iterator[Path]:
    """Give a copy of the project whose cache is empty."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "tendril"
        for name in ("nodes", "catalog", "pipelines"):
            shutil.copytree(ROOT / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "references.bib", root)
        yield root


def run_case(root: Path, *words: str) -> dict[str, float]:
    """Run one case in a process of its own; return wall seconds and the most memory held."""
    started = time.perf_counter()
    command = [sys.executable, "-m", "pipelines.cli", "run", "--no-prefect", *words]
    data = os.environ.get("TENDRIL_TEST_DATA") or ROOT.parent / "shared" / "data"
    process = subprocess.Popen(
        command,
        cwd=root,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env=os.environ | {"TENDRIL_TEST_DATA": str(data)},
    )
    text = process.stdout.read().decode() if process.stdout else ""
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - started
    if status:
        raise SystemExit(f"{' '.join(words)} failed:\n{text}")
    cpu = usage.ru_utime + usage.ru_stime
    return {"seconds": seconds, "cpu_seconds": cpu, "memory_gb": usage.ru_maxrss / 1e6}


REAL: dict[str, Callable[[OpenedCase], dict[str, Any]]] = {
    "chest_p002": measure_chest,
    "chest_normal001": measure_chest,
    "chest_p002_collapsed": measure_collapse,
    "head_ct_straight": measure_nothing,
    "head_ct_tilted": measure_nothing,
    "head_mri": measure_head,
    "mni152": measure_head,
    "med_rad_lung1": measure_sites,
}


def run_real() -> dict[str, dict[str, Any]]:
    """Run every public case from its files to its page, with an empty cache."""
    rows = {}
    with fresh_checkout() as root:
        run_case(root, "--case", "mni152")  # compiles the kernels, once for each machine
        shutil.rmtree(root / "data" / "store")
        for name, measure in REAL.items():
            if not Project().is_ready(name):
                print(f"{name}: skipped, its images are not on this machine")
                continue
            rows[name] = run_case(root, "--case", name) | measure(OpenedCase(Project(root), name))
            print_row(name, rows[name])
        if {"head_ct_straight", "head_ct_tilted"} <= rows.keys():
            rows["tilt"] = measure_tilt(Project(root))
            print_row("tilted against straight", rows["tilt"])
    return rows


def measure_tilt(project: Project) -> dict[str, float]:
    """Return by how much the bone of the two heads differs, by threshold in HU."""
    heads = (OpenedCase(project, f"head_ct_{name}").load("ct") for name in ("straight", "tilted"))
    scans = lay_together(*heads)
    return {f"bone_{hu}_percent": 100 * bone_ratio(scans, hu) - 100 for hu in (150, 300, 500)}


def run_sizes() -> dict[str, dict[str, float]]:
    """Run one chest at its own voxels, and with fewer in the plane."""
    rows = {}
    with fresh_checkout() as root:
        case = OpenedCase(Project(), "chest_p002")
        ct = read_volume(case.load("ct_files"), case.parameters("read_volume"))
        for pixels in (512, 362, 256):
            write_scaled(ct, pixels, root / "data" / "raw" / f"{pixels}.mha")
            text = (
                f"title: {pixels} pixels\npipeline: anatomy\ninputs: {{ct_files: {pixels}.mha}}\n"
            )
            (root / "catalog" / "cases" / f"size_{pixels}.yml").write_text(text)
            cost = run_case(root, "--case", f"size_{pixels}")
            rows[str(pixels)] = {"mvoxels": pixels**2 * ct.voxels.shape[2] / 1e6} | cost
            print_row(f"{pixels} x {pixels} x {ct.voxels.shape[2]}", rows[str(pixels)])
    return rows


def write_scaled(ct: Volume, pixels: int, path: Path) -> None:
    """Write a volume with this many pixels along both sides of its planes, the same field."""
    import SimpleITK as sitk

    path.parent.mkdir(parents=True, exist_ok=True)
    image = sitk.GetImageFromArray(ct.voxels.transpose(2, 1, 0))
    image.SetSpacing(spacing_mm(ct.patient_from_index).tolist())
    factor = image.GetSize()[0] / pixels
    spacing = [
        image.GetSpacing()[0] * factor,
        image.GetSpacing()[1] * factor,
        image.GetSpacing()[2],
    ]
    size = [pixels, pixels, image.GetSize()[2]]
    scaled = sitk.Resample(
        image, size, sitk.Transform(), sitk.sitkLinear, image.GetOrigin(), spacing
    )
    sitk.WriteImage(scaled, str(path))


def run_distance(repeats: int) -> dict[str, float]:
    """Compare the exact distance to the cells' faces with SciPy's to their centres."""
    from scipy import ndimage

    shape = (240, 200, 200)
    i, j, k = np.indices(shape, np.float32)
    free = ((i - 119.5) / 1.2) ** 2 + (j - 99.5) ** 2 + ((k - 99.5) / 0.9) ** 2 < 90**2
    cells = LabelMap(free.astype(np.uint8), np.eye(4), ("free", "boundary"), Origin("a ball"))
    measure_distance(cells)  # compiles
    ours = median_seconds(lambda: measure_distance(cells), repeats)
    plain = median_seconds(
        lambda: [ndimage.distance_transform_edt(mask) for mask in (free, ~free)], repeats
    )
    row = {"mcells": free.size / 1e6, "seconds": ours, "scipy_seconds": plain}
    # Six passes (three axes, inside and outside) read and write 4 bytes a cell at least.
    row["limit_seconds"] = 6 * 8 * free.size / memory_bandwidth()
    print_row("distance field", row)
    return row


def memory_bandwidth() -> float:
    """Return bytes a second that one core copies, read and write together."""
    block = np.zeros(1 << 27, np.uint8)
    target = np.empty_like(block)
    return 2 * block.size / median_seconds(lambda: np.copyto(target, block), 5)


def median_seconds(work: Callable[[], Any], repeats: int) -> float:
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        work()
        times.append(time.perf_counter() - started)
    return statistics.median(times)


def run_phantoms(count: int) -> dict[str, Any]:
    """Score phantoms one by one; return the worst of each figure beside all rows."""
    rows = []
    for seed in range(count):
        rows.append(score_phantom(seed))
        print_row(f"phantom {seed}", rows[-1])
    worst = {f"dice_{name}": min(row[f"dice_{name}"] for row in rows) for name in GOALS}
    worst["cavity_error_percent"] = max(abs(row["cavity_error_percent"]) for row in rows)
    print_row("worst", worst)
    return {"rows": rows, "worst": worst}


def print_row(name: str, row: dict[str, Any]) -> None:
    cells = (f"{k} {v:.4g}" if isinstance(v, float) else f"{k} {v}" for k, v in row.items())
    print(f"{name:22}  {'  '.join(cells)}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--phantoms", type=int, default=10)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--only", nargs="+", default=["phantoms", "real", "sizes", "distance"])
    chosen = parser.parse_args()
    results: dict[str, Any] = {}
    if "phantoms" in chosen.only:
        results["phantoms"] = run_phantoms(chosen.phantoms)
    if "real" in chosen.only:
        results["real"] = run_real()
    if "sizes" in chosen.only and Project().is_ready("chest_p002"):
        results["sizes"] = run_sizes()
    if "distance" in chosen.only:
        results["distance"] = run_distance(chosen.repeats)
    print(json.dumps(results))


if __name__ == "__main__":
    main()
