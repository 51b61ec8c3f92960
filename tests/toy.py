"""A project of three small stages in a folder of its own, run as people run the real one.

It is the real catalog, engine and command line around nodes that a test can edit, break and kill.
"""

import json
import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from pipelines.kernel_cache import VARIABLE

ROOT = Path(__file__).resolve().parent.parent

NODES = {
    "nodes/toy/__init__.py": '"""Toy nodes."""\n',
    "nodes/toy/parameters.py": """
        from nodes.parameters import Parameters

        class CountParameters(Parameters):
            count: int
            '''How many numbers; no unit.'''

        class DoubleParameters(Parameters):
            factor: float
            '''What each number is multiplied by; no unit.'''
        """,
    "nodes/toy/count_up.py": """
        from nodes.toy.parameters import CountParameters

        def count_up(seed_file: dict, parameters: CountParameters) -> dict:
            '''Count from a start.'''
            start = seed_file["start"]
            return {"values": [start + n for n in range(parameters.count)]}
        """,
    "nodes/toy/double_numbers.py": """
        from nodes.toy.helper import scale
        from nodes.toy.parameters import DoubleParameters

        def double_numbers(numbers: dict, parameters: DoubleParameters) -> dict:
            '''Multiply numbers.'''
            return {"values": [scale(v, parameters.factor) for v in numbers["values"]]}
        """,
    "nodes/toy/helper.py": """
        from nodes.toy import deeper

        def scale(value: float, factor: float) -> float:
            return deeper.multiply(value, factor)

        def unused(value: float) -> float:
            return value
        """,
    "nodes/toy/deeper.py": """
        def multiply(a: float, b: float) -> float:
            return a * b
        """,
    "nodes/toy/sum_up.py": """
        import numpy as np

        def sum_up(doubled: dict) -> dict:
            '''Add numbers.'''
            return {"total": float(np.sum(doubled["values"])), "big": "x" * 20000}
        """,
    "nodes/toy/tell_total.py": """
        from nodes.reporting.artefacts import Page, RunAccount

        def tell_total(total: dict, run_account: RunAccount) -> Page:
            '''Tell the sum.'''
            stages = ", ".join(f"{s.name} {s.status}" for s in run_account.stages)
            return Page(f"<!doctype html><p>{total['total']}</p><p>{stages}</p>")
        """,
    "pipelines/toy.py": """
        from pipelines.stage import Stage

        STAGES = [
            Stage("toy.count_up", ["seed_file"], ["numbers"]),
            Stage("toy.double_numbers", ["numbers"], ["doubled"]),
            Stage("toy.sum_up", ["doubled"], ["total"]),
            Stage("toy.tell_total", ["total", "run_account"], ["page"]),
        ]
        """,
    "pipelines/registry.py": """
        from pipelines import toy

        PIPELINES = {"toy": toy}
        """,
    "catalog/catalog.yml": """
        seed_file: {about: where to start, format: record, place: input, option: --seed}
        numbers: {about: numbers, format: record}
        doubled: {about: numbers, format: record}
        total: {about: a number, format: record}
        run_account: {about: the run, place: run}
        page: {about: the page, format: page, place: "reports/{case}.html"}
        """,
    "catalog/parameters/count_up.yml": "count: 4\n",
    "catalog/parameters/double_numbers.yml": "factor: 2.0\n",
    "catalog/cases/one.yml": """
        title: Case one
        pipeline: toy
        inputs: {seed_file: seed/record.json}
        """,
    "data/raw/seed/record.json": '{"start": 1}\n',
}
STAGES = ("count_up", "double_numbers", "sum_up", "tell_total")


class Toy:
    """The project in `root`; each call is a new process, as for a person."""

    def __init__(self, root: Path) -> None:
        self.root = root
        for folder in ("nodes", "catalog", "pipelines"):
            ignore = shutil.ignore_patterns("__pycache__", "cases", "parameters", "imaging")
            shutil.copytree(ROOT / folder, root / folder, ignore=ignore)
        for name, text in NODES.items():
            self.write(name, textwrap.dedent(text).lstrip())

    def write(self, name: str, text: str) -> None:
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def edit(self, name: str, old: str, new: str) -> None:
        text = (self.root / name).read_text()
        assert old in text
        self.write(name, text.replace(old, new))

    def command(self, *words: str) -> list[str]:
        return [sys.executable, "-m", "pipelines.cli", *words]

    def call(self, *words: str, code: int = 0) -> str:
        """Run `tendril` and return all that it printed; its exit code must be as told."""
        done = self._run(self.command(*words))
        assert done.returncode == code, done.stdout + done.stderr
        return done.stdout + done.stderr

    def run(self, *words: str, code: int = 0) -> str:
        return self.call("run", "--no-prefect", "--case", "one", *words, code=code)

    def python(self, source: str, code: int = 0) -> str:
        """Run Python in the project and return what it printed."""
        words = [sys.executable, "-c", textwrap.dedent(source)]
        done = self._run(words)
        assert done.returncode == code, done.stdout + done.stderr
        return done.stdout

    def _run(self, words: list[str]) -> subprocess.CompletedProcess:
        environment = {k: v for k, v in os.environ.items() if k != VARIABLE}  # kernels of its own
        return subprocess.run(words, cwd=self.root, capture_output=True, text=True, env=environment)

    @property
    def latest(self) -> Path:
        return self.root / "data" / "runs" / "one" / "latest"

    def told(self) -> dict:
        return json.loads((self.latest / "run.json").read_text())

    def computed(self) -> list[str]:
        """Return the stages that the newest run computed, in order."""
        return [name for name, status in self.told()["stages"].items() if status == "computed"]

    def total(self) -> float:
        return json.loads((self.latest / "total.json").read_text())["total"]

    def object_file(self, dataset: str) -> Path:
        """Return the real file of an artefact of the newest run."""
        return next(self.latest.glob(f"{dataset}.*")).resolve()


@pytest.fixture
def toy(tmp_path: Path) -> Toy:
    return Toy(tmp_path / "toy")
