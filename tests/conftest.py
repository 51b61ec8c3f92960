"""Fixtures for all tests: real data where they are, and shapes checked in every call."""

import os
from pathlib import Path

import pytest
from hypothesis import settings
from jaxtyping import install_import_hook

from pipelines.kernel_cache import use_kernel_cache

ROOT = Path(__file__).resolve().parent.parent
# Before any node is imported: shapes and types of all arguments and results of nodes are checked,
# but of kernels, which take what nodes have checked.
ROOMS = [path.parent.name for path in (ROOT / "nodes").glob("*/__init__.py")]
install_import_hook([f"nodes.{room}" for room in ROOMS if room != "kernels"], "beartype.beartype")
use_kernel_cache(ROOT)
# The same examples in every run: a change is what makes a property fail, and nothing else.
settings.register_profile("steady", derandomize=True, deadline=None)
settings.load_profile("steady")
pytest_plugins = ["tests.browser", "tests.toy"]


def data_folder() -> Path:
    """Return where the public test images are, if they are on this machine."""
    return Path(os.environ.get("TENDRIL_TEST_DATA") or ROOT.parent / "shared" / "data")


@pytest.fixture(scope="session")
def test_data() -> Path:
    """The folder of public test images, named by TENDRIL_TEST_DATA."""
    folder = data_folder()
    if not folder.is_dir():
        pytest.skip(f"no test data at {folder}: set TENDRIL_TEST_DATA")
    return folder


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Keep each file on one worker, and all that needs the same kernels: they compile once."""
    for item in items:
        item.add_marker(pytest.mark.xdist_group(_worker_group(item.path)))


def _worker_group(path: Path) -> str:
    if path.parent.name not in ("kernels", "mechanics"):
        return str(path)
    concentric = any(word in path.name for word in ("ctr", "concentric", "nystroem"))
    return "concentric tubes" if concentric else "CRISP"
