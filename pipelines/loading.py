"""How this process loads the project's own modules: from source, and remembering the source.

Python takes a compiled file for fresh if the source has the same size and was written in the same
second; an edit within that second would run as the old code under the new code's key. So the nodes
and the catalog are compiled anew in each process that needs them, which takes milliseconds. What
was loaded is remembered: a notebook goes on with what it loaded, whatever is edited later.
"""

import importlib.machinery
import importlib.util
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

PACKAGES = ("nodes", "catalog")
# Source of every module of the project that this process has loaded.
loaded: dict[str, bytes] = {}


class _FromSource(importlib.machinery.SourceFileLoader):
    """Loads a module from its source alone."""

    def path_stats(self, path: str) -> dict:
        """Answer that nothing is known of the file, so that no compiled file is used or written."""
        raise OSError("compiled files are not used")

    def get_data(self, path: str) -> bytes:
        """Return a file's bytes; where it is the module's own source, remember it."""
        data = super().get_data(path)
        if path == self.path:
            loaded[self.name] = data
        return data


class _Finder:
    """Gives the project's modules that loader; whoever else wraps them (tests do) goes first."""

    @classmethod
    def find_spec(
        cls, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if name.partition(".")[0] not in PACKAGES:
            return None
        others = [f for f in sys.meta_path if f is not cls and hasattr(f, "find_spec")]
        spec = next(filter(None, (f.find_spec(name, path, target) for f in others)), None)
        if spec and type(spec.loader) is importlib.machinery.SourceFileLoader:
            spec.loader = _FromSource(spec.loader.name, spec.loader.path)
        return spec


def load_from_source() -> None:
    """Load the project's modules from source from now on; call it before any is imported."""
    if _Finder not in sys.meta_path:
        _note_what_is_loaded_already()
        sys.meta_path.insert(0, _Finder)  # type: ignore[arg-type]


def _note_what_is_loaded_already() -> None:
    """Take modules that were imported before us for what their files hold, if those are older.

    A file that changed since this process began may have been loaded before it did: then what was
    loaded is unknown, and an empty source stands for it, which fits no key.
    """
    began = _process_start()
    for name, module in list(sys.modules.items()):
        path = getattr(module, "__file__", None)
        if name.partition(".")[0] in PACKAGES and path and path.endswith(".py"):
            is_older = os.stat(path).st_ctime < began
            loaded[name] = Path(path).read_bytes() if is_older else b""


def _process_start() -> float:
    """Return when this process began, in s since 1970 (proc(5): field 22, in clock ticks)."""
    try:
        fields = Path("/proc/self/stat").read_text().rpartition(")")[2].split()
    except OSError:  # no Linux: nothing is known, and every file counts as younger
        return 0.0
    since_boot = int(fields[19]) / os.sysconf("SC_CLK_TCK")
    return time.time() - (time.clock_gettime(time.CLOCK_BOOTTIME) - since_boot)
