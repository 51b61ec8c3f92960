"""From a CT to a page, on the phantom and on real scans, as a person runs it."""

import gzip
import json
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import pandas as pd
import pydicom
import pytest

from tests.checkout import Checkout

SECRETS = {
    "PatientName": "Qwxdoe^Zvjane",
    "PatientID": "ID-424242",
    "PatientBirthDate": "19330117",
    "StudyDate": "20190523",
    "SeriesDate": "20190524",
    "AcquisitionDate": "20190525",
    "AccessionNumber": "ACC777111",
    "InstitutionName": "Saint Elsewhere",
    "ReferringPhysicianName": "Roe^Richard",
    "StudyDescription": "Thorax of Qwxdoe",
    "SeriesDescription": "Qwxdoe lungs",
    "PatientComments": "lives at 12 Elm Street",
}


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Checkout:
    checkout = Checkout(tmp_path_factory.mktemp("checkout") / "tendril")
    checkout.call("run", "--case", "thorax_phantom")
    return checkout


def test_the_phantom_runs_to_a_page_and_is_called_simulated(checkout: Checkout) -> None:
    told = json.loads((checkout.latest("thorax_phantom") / "run.json").read_text())
    assert told["status"] == "complete"
    page = (checkout.root / "reports/thorax_phantom.html").read_text()
    assert "simulated" in page
    assert "not a medical device" in page
    scores = checkout.table("thorax_phantom", "score_table")
    for name, dice in {"lungs": 0.97, "effusion": 0.97, "bone": 0.95, "airway": 0.90}.items():
        assert scores[name]["dice"] > dice, name
    assert abs(scores["effusion"]["volume_error_percent"]) < 2
    assert len(pd.read_csv(checkout.latest("thorax_phantom") / "entry_table/table.csv")) > 0


def test_every_artefact_stands_under_its_name_in_a_format_of_the_field(checkout: Checkout) -> None:
    names = {path.name for path in checkout.latest("thorax_phantom").iterdir()}
    assert {"ct.nrrd", "label_map.seg.nrrd", "occupancy_grid.seg.nrrd", "surfaces"} <= names
    assert {"truth.seg.nrrd", "ct_files", "page.html", "run.json"} <= names
    surfaces = {p.stem[3:] for p in (checkout.latest("thorax_phantom") / "surfaces").glob("*.ply")}
    assert surfaces == {"body", "bone", "left_lung", "right_lung", "airway", "effusion"}
    assert {"distance_field.nrrd", "entry_map.seg.nrrd", "entry_table", "point_cloud"} <= names


def test_all_pages_open_without_an_error_or_a_request(checkout: Checkout, open_page) -> None:
    for name in ("thorax_phantom", "index"):
        open_page(checkout.root / "reports" / f"{name}.html").assert_quiet()


def test_a_rerun_of_the_real_pipeline_computes_nothing(checkout: Checkout) -> None:
    assert "nothing to do" in checkout.call("run", "--case", "thorax_phantom")


@pytest.fixture(scope="module")
def patient(checkout: Checkout, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The phantom's DICOM series with the identifiers of a made-up patient in every file."""
    folder = tmp_path_factory.mktemp("scans") / "Qwxdoe_Zvjane"
    source = checkout.latest("thorax_phantom") / "ct_files"
    for number, path in enumerate(sorted(source.rglob("*.dcm"))):
        dataset = pydicom.dcmread(path)
        for tag, value in SECRETS.items():
            setattr(dataset, tag, value)
        # Against the standard, which makes libraries warn and quote what they found.
        dataset.add_new("FrameOfReferenceUID", "UI", "Qwxdoe-uid")
        dataset.add_new("PatientAge", "AS", "Qwxdoe-old")
        dataset.add_new((0x0009, 0x0010), "LO", "Qwxdoe private")
        target = folder / f"{number:03d}_ID-424242.dcm"
        target.parent.mkdir(parents=True, exist_ok=True)
        dataset.save_as(target)
    return folder


def readable_bytes(path: Path) -> Iterator[bytes]:
    """Yield a file's bytes, and what is compressed within it."""
    data = path.read_bytes()
    yield data
    for start in (data.find(b"\x1f\x8b"), data.find(b"x\x01")):
        if start >= 0:
            try:
                yield zlib.decompressobj(zlib.MAX_WBITS | 32).decompress(data[start:])
            except zlib.error:
                continue
    if data[:2] == b"\x1f\x8b":
        yield gzip.GzipFile(fileobj=BytesIO(data)).read()


def test_no_identifier_reaches_an_artefact_a_page_or_a_log(
    checkout: Checkout, patient: Path
) -> None:
    assert any(b"Qwxdoe^Zvjane" in f.read_bytes() for f in patient.iterdir())
    checkout.call("new-case", "privacy", "--ct", str(patient))
    printed = checkout.call("run", "--case", "privacy")
    words = [value.encode() for value in SECRETS.values()] + [
        b"Qwxdoe",
        b"Elm Street",
        b"ID-424242",
    ]
    uids = [str(pydicom.dcmread(next(patient.iterdir())).StudyInstanceUID).encode()]
    files = [p for f in ("data", "reports") for p in (checkout.root / f).rglob("*") if p.is_file()]
    # What the phantom itself wrote is a file of the phantom's, not of this patient's.
    phantom = (checkout.latest("thorax_phantom") / "ct_files").resolve()
    for path in files:
        if phantom in path.parents:
            continue
        for data in readable_bytes(path):
            found = [word for word in words + uids if word in data]
            assert not found, (path, found)
    assert "Qwxdoe" not in printed
    assert json.loads((checkout.latest("privacy") / "run.json").read_text())["status"] == "complete"
