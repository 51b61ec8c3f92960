"""What setup.sh says on a machine that lacks something."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture
def bare(tmp_path: Path) -> Path:
    """A copy of the set-up and a PATH with nothing but what the test puts there."""
    for name in ("setup.sh", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, tmp_path / name)
    programs = tmp_path / "bin"
    programs.mkdir()
    for name in ("sh", "dirname", "flock", "grep", "cat", "ls", "touch"):
        (programs / name).symlink_to(shutil.which(name) or f"/bin/{name}")
    fake(tmp_path, "id", "echo 1000")
    fake(tmp_path, "ldconfig", "echo 'libEGL.so.1 libGL.so.1 libusb-1.0.so.0'")
    return tmp_path


def fake(folder: Path, name: str, line: str) -> None:
    path = folder / "bin" / name
    path.write_text(f"#!/bin/sh\n{line}\n")
    path.chmod(0o755)


def set_up(folder: Path) -> subprocess.CompletedProcess:
    return subprocess.run(
        [folder / "setup.sh", "venv"],
        env={"PATH": str(folder / "bin"), "HOME": os.environ.get("HOME", "/")},
        capture_output=True, text=True,
    )  # fmt: skip


def test_missing_libraries_are_told_with_the_exact_line(bare: Path) -> None:
    fake(bare, "ldconfig", "echo libGL.so.1")
    done = set_up(bare)
    assert done.returncode == 1
    assert "sudo apt-get install -y libegl1 libusb-1.0-0\n" in done.stderr
    assert not (bare / "venv").exists()


def test_a_missing_python_is_told(bare: Path) -> None:
    done = set_up(bare)
    assert done.returncode == 1
    assert "no Python 3.11, 3.12 or 3.13 found" in done.stderr


def test_a_python_without_venv_is_told_with_the_exact_line(bare: Path) -> None:
    version = 'case "$2" in *ensurepip*) exit 1;; *print*) echo python3.12-venv;; esac'
    fake(bare, "python3", version)
    done = set_up(bare)
    assert done.returncode == 1
    assert "sudo apt-get install -y python3.12-venv\n" in done.stderr


def test_what_is_set_up_already_is_not_set_up_again(bare: Path) -> None:
    (bare / "venv").mkdir()
    (bare / "venv" / "ready").touch()
    done = set_up(bare)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_constraints_are_names_and_versions_only() -> None:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pins = [line for line in lines if line and not line.startswith("#")]
    assert all("==" in pin and "/" not in pin and " " not in pin for pin in pins)
    assert len({pin.partition("==")[0].lower() for pin in pins}) == len(pins)
