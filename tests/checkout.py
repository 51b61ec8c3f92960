"""A copy of the project with a data folder of its own, run as a person runs it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd

from tests.conftest import ROOT, data_folder


class Checkout:
    """A copy of the project, with its own data folder."""

    def __init__(self, root: Path) -> None:
        self.root = root
        for folder in ("nodes", "catalog", "pipelines"):
            ignore = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / folder, root / folder, ignore=ignore)

    def call(self, *words: str, code: int = 0) -> str:
        command = [sys.executable, "-m", "pipelines.cli", *words]
        environment = os.environ | {"TENDRIL_TEST_DATA": str(data_folder())}
        done = subprocess.run(
            command, cwd=self.root, capture_output=True, text=True, env=environment
        )
        assert done.returncode == code, done.stdout + done.stderr
        return done.stdout + done.stderr

    def latest(self, case: str) -> Path:
        return self.root / "data" / "runs" / case / "latest"

    def table(self, case: str, dataset: str) -> dict[str, dict]:
        table = pd.read_csv(self.latest(case) / dataset / "table.csv")
        return table.set_index("label").to_dict("index")
