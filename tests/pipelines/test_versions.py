"""Versions are those of what is installed, however long ago that was remembered."""

import json
import sys
from importlib import metadata
from pathlib import Path

import pytest

from pipelines.versions import package_versions


def install(site: Path, name: str, version: str, imports: str) -> None:
    info = site / f"{name}-{version}.dist-info".replace("-", "_", name.count("-"))
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    (info / "top_level.txt").write_text(imports)


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "env" / "site-packages"
    folder.mkdir(parents=True)
    monkeypatch.syspath_prepend(folder)
    return folder


def test_imports_are_told_as_the_distributions_that_bring_them(tmp_path: Path) -> None:
    told = package_versions(["nrrd", "numpy", "SimpleITK", "PIL", "yaml"], tmp_path / "m.json")
    python = ".".join(map(str, sys.version_info[:3]))
    assert told.pop("python").startswith(python)
    assert told == {
        name: metadata.version(name)
        for name in ("numpy", "pillow", "pynrrd", "PyYAML", "simpleitk")
        for name in [metadata.metadata(name)["Name"]]
    }


def test_what_is_not_installed_is_told_as_that(tmp_path: Path) -> None:
    assert (
        package_versions(["no_such_thing"], tmp_path / "m.json")["no_such_thing"] == "not installed"
    )


def test_a_new_version_is_told_though_the_old_was_remembered(tmp_path: Path, site: Path) -> None:
    memory = tmp_path / "m.json"
    install(site, "toything", "1.0", "toy_import")
    assert package_versions(["toy_import"], memory)["toything"] == "1.0"
    (site / "toything-1.0.dist-info").rename(tmp_path / "old")
    install(site, "toything", "2.0", "toy_import")
    assert package_versions(["toy_import"], memory)["toything"] == "2.0"


def test_a_package_installed_later_is_told(tmp_path: Path, site: Path) -> None:
    memory = tmp_path / "m.json"
    assert package_versions(["toy_import"], memory)["toy_import"] == "not installed"
    install(site, "toything", "1.0", "toy_import")
    assert package_versions(["toy_import"], memory)["toything"] == "1.0"


def test_an_import_that_two_distributions_bring_counts_with_both(
    tmp_path: Path, site: Path
) -> None:
    install(site, "toy-one", "1.0", "toy_shared")
    install(site, "toy-two", "2.0", "toy_shared")
    told = package_versions(["toy_shared"], tmp_path / "m.json")
    assert (told["toy-one"], told["toy-two"]) == ("1.0", "2.0")


@pytest.mark.parametrize("content", ["", "[]", "{", '{"stamp": 1}', '{"providers": {}}', "STAMPED"])
def test_a_damaged_memory_costs_only_time(tmp_path: Path, content: str) -> None:
    memory = tmp_path / "m.json"
    expected = package_versions(["numpy"], memory)
    if content == "STAMPED":
        content = json.dumps({**json.loads(memory.read_text()), "providers": None})
    memory.write_text(content)
    assert package_versions(["numpy"], memory) == expected
