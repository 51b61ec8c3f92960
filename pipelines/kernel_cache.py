"""Where Numba keeps what it compiled: a folder for each state of the kernels' sources."""

import hashlib
import os
import shutil
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"


def use_kernel_cache(root: Path) -> Path:
    """Point Numba to the folder of today's kernels; must come before anything imports Numba.

    Numba looks only at the file of a compiled function, not at the files whose functions it calls:
    an edit there would go unseen. A folder that the person set stays.
    """
    folder = root / "data" / "kernels" / _hash_sources(root / "nodes" / "kernels")
    return Path(os.environ.setdefault(VARIABLE, str(folder)))


def _hash_sources(folder: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def drop_old_kernels(root: Path) -> None:
    """Remove what was compiled from earlier sources."""
    folder = root / "data" / "kernels"
    for path in folder.glob("*"):
        if path.name != _hash_sources(root / "nodes" / "kernels"):
            shutil.rmtree(path, ignore_errors=True)
