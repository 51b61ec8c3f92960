"""Where one statement of the project's source leads: definitions, modules, packages."""

import ast
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from pipelines.source_module import Module

if TYPE_CHECKING:
    from pipelines.source_tree import SourceTree

_UNFOLLOWABLE = {"exec", "eval", "__import__", "import_module", "globals", "vars"}
_UNFOLLOWABLE |= {"__globals__", "__subclasses__", "__init_subclass__"}
# Of the standard library, what finds code by its name; "importlib" itself only as a value.
_FINDERS = ("builtins", "importlib.machinery", "importlib.util", "pickle", "pkgutil", "runpy")
_FINDERS += ("sys.modules",)
WHOLE = "*"
"""The name that stands for all of a module."""


@dataclass
class Links:
    """What a statement, or a name in a module, leads to.

    Parameters
    ----------
    opened : places (module, definition), WHOLE for all of a module.
    entered : dotted names of modules that it imports when it runs.
    packages : that are not the project's own.
    is_unfollowable : whether it may find code by its name, so that everything counts.
    """

    opened: list[tuple[str, str]] = field(default_factory=list)
    entered: list[str] = field(default_factory=list)
    packages: set[str] = field(default_factory=set)
    is_unfollowable: bool = False


class LinkReader:
    """Reads links, each once, however many functions reach the same statement."""

    def __init__(self, tree: "SourceTree") -> None:
        self._tree = tree
        self._known: dict[tuple[str, str], Links] = {}

    def of_statement(self, name: str, module: Module, statement: ast.stmt) -> Links:
        """Return where the statement that is called `name` leads."""
        key = (name, "")
        if key not in self._known:
            self._known[key] = self._read(module, statement)
        return self._known[key]

    def of_name(self, module: Module, name: str) -> Links:
        """Return where a name that a module imports leads; of WHOLE, where all of them do."""
        key = (module.name, name)
        if key not in self._known:
            wanted = [name] if name != WHOLE else list(module.meanings)
            links = self._known[key] = Links()
            for one in wanted:
                self._follow_all(module.meanings.get(one, ()), links)
        return self._known[key]

    def _read(self, module: Module, statement: ast.stmt) -> Links:
        links = Links()
        names = {name: list(dotted) for name, dotted in module.meanings.items()}
        for inner in ast.walk(statement):
            if isinstance(inner, ast.Import | ast.ImportFrom):
                for local, dotted in module.imported_names(inner).items():
                    names.setdefault(local, []).append(dotted)
                for dotted in module.loaded_by(inner):
                    links.entered.append(dotted)
                    self._note_package(dotted, links)
            elif isinstance(inner, ast.FunctionDef) and inner.name in _UNFOLLOWABLE:
                links.is_unfollowable = True
        for dotted in dict.fromkeys(_names_in(statement)):
            self._follow_name(dotted, module, names, links)
        links.opened = list(dict.fromkeys(links.opened))
        return links

    def _follow_name(
        self, dotted: str, module: Module, names: dict[str, list[str]], links: Links
    ) -> None:
        first, _, rest = dotted.partition(".")
        if _UNFOLLOWABLE & set(dotted.split(".")):
            links.is_unfollowable = True
        meant = (name + (f".{rest}" if rest else "") for name in names.get(first, ()))
        self._follow_all(meant, links)
        if first in module.definitions:
            links.opened.append((module.name, first))
        links.opened += [(star, first) for star in module.stars]

    def _follow_all(self, dotted: Iterable[str], links: Links) -> None:
        for name in dotted:
            self._follow_dotted(name, links)

    def _follow_dotted(self, dotted: str, links: Links) -> None:
        """Follow "package.module.definition.attribute": the longest part that is a module."""
        self._note_package(dotted, links)
        if _finds_code(dotted):
            links.is_unfollowable = True
        parts = dotted.split(".")
        for cut in range(len(parts), 0, -1):
            module = ".".join(parts[:cut])
            if self._tree.module(module):
                rest = parts[cut:]
                links.opened.append((module, rest[0] if rest else WHOLE))
                return

    def _note_package(self, dotted: str, links: Links) -> None:
        top = dotted.partition(".")[0]
        if top not in self._tree.packages and top not in sys.stdlib_module_names:
            links.packages.add(top)


def _finds_code(dotted: str) -> bool:
    """Return whether a name of the standard library finds code by its name."""
    if dotted.partition(".")[0] not in sys.stdlib_module_names:
        return False
    inside = any(f"{dotted}.".startswith(f"{finder}.") for finder in _FINDERS)
    return inside or dotted == "importlib" or dotted.rpartition(".")[2] in _UNFOLLOWABLE


def _names_in(statement: ast.stmt) -> Iterator[str]:
    """Yield every name, and "a.b.c" instead of "a" where attributes of a name are used."""
    inner_parts = set()
    for node in ast.walk(statement):
        if id(node) in inner_parts or not isinstance(node, ast.Name | ast.Attribute):
            continue
        dotted = node.id if isinstance(node, ast.Name) else _dotted(node)
        if dotted:
            yield dotted
            while isinstance(node, ast.Attribute):
                node = node.value
                inner_parts.add(id(node))


def _dotted(node: ast.Attribute) -> str:
    """Return "a.b.c" for an attribute chain on a plain name, else ""."""
    parts: list[str] = []
    inner: ast.expr = node
    while isinstance(inner, ast.Attribute):
        parts.append(inner.attr)
        inner = inner.value
    return ".".join([inner.id, *reversed(parts)]) if isinstance(inner, ast.Name) else ""
