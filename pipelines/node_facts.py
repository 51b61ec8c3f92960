"""What the engine must know of a stage's node before it runs: arguments, code, parameter type."""

import os
import sys
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from catalog.datasets import Dataset, find_dataset
from catalog.memory import recall, remember
from nodes.errors import BadInput
from pipelines.loading import loaded
from pipelines.source_tree import SourceTree
from pipelines.stage import Stage

# See catalog.signatures: a file that changed within the last tick may change again unseen.
_TICK_NS = 1_000_000_000


@dataclass(frozen=True)
class NodeFacts:
    """Read from the source alone.

    Parameters
    ----------
    summary : first line of the function's docstring.
    arguments : names of its arguments but `parameters`.
    parameters : module and class of its parameter type, "" where it has none.
    code : name -> hash of every definition that the function and the formats of its datasets reach.
    packages : names of the packages that those import.
    """

    summary: str
    arguments: list[str]
    parameters: str
    code: dict[str, str]
    packages: list[str]

    def parameters_type(self) -> Any:
        """Import the parameter type."""
        module, _, name = self.parameters.partition(":")
        return getattr(import_module(module), name)


class NodeReader:
    """Reads facts of nodes, and remembers them for as long as no source file is touched."""

    def __init__(self, root: Path, catalog: Mapping[str, Dataset], memory: Path) -> None:
        self._root, self._catalog, self._memory = root, dict(catalog), memory
        self._tree = SourceTree(root)
        self.stamp = self._stamp()
        known = recall(memory)
        usable = known.get("stamp") == self.stamp and known.get("python") == sys.version
        self._known: dict[str, dict] = known.get("facts", {}) if usable else {}

    def facts(self, stage: Stage) -> NodeFacts:
        """Return the facts of a stage's node.

        Raises
        ------
        BadInput : if the stage names a node, an argument or a dataset that does not exist.
        """
        place = repr((stage.target, stage.arguments, stage.outputs))
        if place not in self._known:
            self._known[place] = asdict(self._read(stage, self._tree))
            self._remember()
        return NodeFacts(**self._known[place])

    def is_still(self, stage: Stage, code: Mapping[str, str]) -> bool:
        """Return whether the code that this process has loaded for a stage is that of its key.

        It is not where a file was edited after it was loaded, or between plan and import; an edit
        that the stage does not reach does no harm.
        """
        if self._stamp() == self.stamp and not _edited_since_loaded(self._root):
            return True
        as_loaded = SourceTree(self._root, loaded=loaded)
        return self._read(stage, as_loaded).code == code

    def _remember(self) -> None:
        newest = max(row[4] for row in self.stamp)
        if newest + _TICK_NS < time.time_ns():
            facts = {"stamp": self.stamp, "python": sys.version, "facts": self._known}
            remember(self._memory, facts)

    def _read(self, stage: Stage, tree: SourceTree) -> NodeFacts:
        try:
            return self._gather(stage, tree)
        except SyntaxError as error:
            raise BadInput(
                f"{Path(error.filename or '').name}, line {error.lineno}: {error.msg}",
                "source must be Python",
                "mend the file",
            ) from error

    def _gather(self, stage: Stage, tree: SourceTree) -> NodeFacts:
        try:
            signature = tree.signature(stage.target)
        except LookupError as error:
            raise BadInput(
                f"stage {stage.name}: {error.args[0]}",
                "a node is a function in a file of its own name",
                "mend the pipeline's list of stages",
            ) from error
        self._check_arguments(stage, signature.arguments, signature.takes_more)
        reach = tree.reach(stage.target)
        for name in (*stage.inputs, *stage.outputs):
            if target := find_dataset(self._catalog, name).format_target:
                more = tree.reach(target)
                reach.definitions |= more.definitions
                reach.packages |= more.packages
        parameters = self._parameters_target(stage, signature.parameters_type)
        return NodeFacts(
            signature.summary,
            list(signature.arguments),
            parameters,
            dict(sorted(reach.definitions.items())),
            sorted(reach.packages),
        )

    def _check_arguments(self, stage: Stage, arguments: tuple[str, ...], takes_more: bool) -> None:
        missing = set(arguments) - set(stage.arguments)
        strange = set() if takes_more else set(stage.arguments) - set(arguments)
        if missing or strange:
            raise BadInput(
                f"stage {stage.name}: inputs {', '.join(stage.arguments) or 'none'}",
                f"its node takes {', '.join(arguments) or 'nothing'}",
                "name the inputs as the arguments are named, or map argument: dataset",
            )

    def _parameters_target(self, stage: Stage, written: str) -> str:
        if not written:
            return ""
        home = stage.target.partition(":")[0]
        module = self._tree.module(home)
        name = written.strip("'\"")
        if module and name in module.definitions:
            return f"{home}:{name}"
        source, _, name = (module.imports if module else {}).get(name, "").rpartition(".")
        if not source:
            raise BadInput(
                f"stage {stage.name}: parameters: {written}",
                "the type of parameters must be a class that the node's file imports",
                "write `parameters: NameOfClass`, imported from a parameters module",
            )
        return f"{source}:{name}"

    def _stamp(self) -> list[list]:
        """Return name, size, inode and both times of every file that code is read from."""
        rows = []
        for package in self._tree.packages:
            for folder, folders, names in os.walk(self._root / package, followlinks=True):
                folders[:] = sorted(f for f in folders if f != "__pycache__")
                rows += [_stat_row(os.path.join(folder, name)) for name in sorted(names)]
        return [row for row in rows if "/catalog/cases/" not in row[0]]


def _edited_since_loaded(root: Path) -> bool:
    """Return whether any file differs from what this process loaded from it."""
    for name, source in loaded.items():
        base = root.joinpath(*name.split("."))
        path = base / "__init__.py" if base.is_dir() else base.with_name(f"{base.name}.py")
        if not path.is_file() or path.read_bytes() != source:
            return True
    return False


def _stat_row(path: str) -> list:
    try:
        s = os.stat(path)
    except FileNotFoundError:  # an editor's scratch file, gone since the folder was listed
        return [path, 0, 0, 0, 0]
    return [path, s.st_size, s.st_ino, s.st_mtime_ns, s.st_ctime_ns]
