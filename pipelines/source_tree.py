"""What a function reaches in the project's source, found by reading it, never by importing it.

A definition is a function, a class or an assignment at the top of a module. From the function's
own, every name is followed to the definition that it means, in the same module or through imports
(also those inside functions). What cannot be followed counts as everything: a module passed about
as a value counts whole, `exec` and its like make all of `nodes` count. Comments, docstrings and
layout do not count, unless a reached module reads docstrings. Statements that run when a module is
imported do, also where it is imported by one that is reached: so do changes of what another module
holds, and functions that a decorator of the project's own may note somewhere.
"""

import ast
import copy
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

from pipelines.source_module import Module, Signature, is_text, read_signature

_UNFOLLOWABLE = {"exec", "eval", "__import__", "import_module", "globals", "vars"}
_UNFOLLOWABLE |= {"__globals__", "__subclasses__", "__init_subclass__"}
# Of the standard library, what finds code by its name; "importlib" itself only as a value.
_FINDERS = ("builtins", "importlib.machinery", "importlib.util", "pickle", "pkgutil", "runpy")
_FINDERS += ("sys.modules",)
_WHOLE = "*"


@dataclass
class Reach:
    """What a function reaches: hashes of definitions and files by name, and packages imported."""

    definitions: dict[str, str] = field(default_factory=dict)
    packages: set[str] = field(default_factory=set)


class SourceTree:
    """The project's own modules under a root folder.

    Parameters
    ----------
    loaded : module -> source that takes the place of its file's, as a process has loaded it.
    """

    def __init__(
        self,
        root: Path,
        packages: tuple[str, ...] = ("nodes", "catalog"),
        loaded: Mapping[str, bytes] | None = None,
    ) -> None:
        self.root, self.packages, self._loaded = root, packages, loaded or {}
        self._modules: dict[str, Module | None] = {}

    def reach(self, target: str) -> Reach:
        """Return all that "module:definition" reaches."""
        module, _, name = target.partition(":")
        return _Walk(self).follow(module, name)

    def signature(self, target: str) -> Signature:
        """Return what the source of a function says of its arguments.

        Raises
        ------
        LookupError : if there is no such module or function.
        """
        name, _, function = target.partition(":")
        module = self.module(name)
        found = module.definitions.get(function, []) if module else []
        if not found or not isinstance(found[0], ast.FunctionDef):
            raise LookupError(f"no function {function} in {name}")
        return read_signature(found[0])

    def module(self, name: str) -> Module | None:
        """Return a module of the project, None if the name is no module of it."""
        if name not in self._modules:
            self._modules[name] = self._open(name)
        return self._modules[name]

    def _open(self, name: str) -> Module | None:
        if name.partition(".")[0] not in self.packages:
            return None
        base = self.root.joinpath(*name.split("."))
        for path in (base / "__init__.py", base.with_name(f"{base.name}.py")):
            if path.is_file():
                return Module(name, path, self.packages, self._loaded.get(name))
        return None

    def names_below(self, package: str) -> Iterator[str]:
        """Yield the names of all modules of a package."""
        for path in sorted(self.root.joinpath(package).rglob("*.py")):
            parts = path.relative_to(self.root).with_suffix("").parts
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


class _Walk:
    """One walk from a definition to all that it reaches."""

    def __init__(self, tree: SourceTree) -> None:
        self.tree, self.reached = tree, Reach()
        self._open: list[tuple[str, str]] = []
        self._entered: dict[str, Module] = {}
        self._counted: dict[str, ast.stmt] = {}

    def follow(self, module: str, name: str) -> Reach:
        self._open.append((module, name))
        seen: set[tuple[str, str]] = set()
        while self._open:
            place = self._open.pop()
            if place not in seen:
                seen.add(place)
                self._visit(*place)
        self._hash()
        return self.reached

    def _hash(self) -> None:
        """Hash what was counted, with its docstrings where anything may read them."""
        hashes = self.reached.definitions
        with_text = any(module.reads_docstrings for module in self._entered.values())
        for name, statement in self._counted.items():
            told = statement if with_text else _WithoutText().visit(copy.deepcopy(statement))
            hashes[name] = sha256(ast.dump(told).encode()).hexdigest()
        for module in self._entered.values() if with_text else ():
            hashes[f"{module.name}.<text>"] = sha256(module.texts.encode()).hexdigest()

    def _visit(self, module_name: str, name: str) -> None:
        module = self.tree.module(module_name)
        if module is None:
            return
        self._enter(module)
        self._count_data_files(module)
        if name in (_WHOLE, "__dict__"):
            self._open += [(module_name, other) for other in module.definitions]
            self._open += [(star, _WHOLE) for star in module.stars]
            for dotted in module.meanings.values():
                self._follow_all(dotted)
            return
        for order, statement in enumerate(module.definitions.get(name, ())):
            self._count(f"{module_name}.{name}" + (f"~{order}" if order else ""), module, statement)
        self._follow_all(module.meanings.get(name, ()))
        self._open += [(star, name) for star in module.stars]
        if "__getattr__" in module.definitions:
            self._open.append((module_name, "__getattr__"))

    def _enter(self, module: Module) -> None:
        """Count what importing a module runs: in it, in the packages around it, in its imports."""
        if module.name in self._entered:
            return
        self._entered[module.name] = module
        if module.at_import:
            self._count_data_files(module)
        for order, statement in enumerate(module.at_import):
            self._count(f"{module.name}.<import>{order}", module, statement)
        self._enter_all(module.name)
        for statement in module.imports_run:
            for dotted in module.loaded_by(statement):
                self._enter_all(dotted)

    def _enter_all(self, dotted: str) -> None:
        """Enter the module "a.b.c", and "a" and "a.b", where they are modules."""
        parts = dotted.split(".")
        for end in range(1, len(parts) + 1):
            if module := self.tree.module(".".join(parts[:end])):
                self._enter(module)

    def _count_data_files(self, module: Module) -> None:
        for file in _data_files(module.path.parent) if module.name.startswith("nodes.") else ():
            name = str(file.relative_to(self.tree.root))
            if name not in self.reached.definitions:
                self.reached.definitions[name] = sha256(file.read_bytes()).hexdigest()

    def _count(self, name: str, module: Module, statement: ast.stmt) -> None:
        self._counted[name] = statement
        names = {name: list(dotted) for name, dotted in module.meanings.items()}
        for inner in ast.walk(statement):
            if isinstance(inner, ast.Import | ast.ImportFrom):
                for local, dotted in module.imported_names(inner).items():
                    names.setdefault(local, []).append(dotted)
                for dotted in module.loaded_by(inner):
                    self._enter_all(dotted)
                    self._note_package(dotted)
            elif isinstance(inner, ast.FunctionDef) and inner.name in _UNFOLLOWABLE:
                self._open_all()
        for dotted in _names_in(statement):
            self._follow_name(dotted, module, names)

    def _follow_name(self, dotted: str, module: Module, names: dict[str, list[str]]) -> None:
        first, _, rest = dotted.partition(".")
        if _UNFOLLOWABLE & set(dotted.split(".")):
            self._open_all()
        self._follow_all(name + (f".{rest}" if rest else "") for name in names.get(first, ()))
        if first in module.definitions:
            self._open.append((module.name, first))
        self._open += [(star, first) for star in module.stars]

    def _follow_all(self, dotted: Iterable[str]) -> None:
        for name in dotted:
            self._follow_dotted(name)

    def _follow_dotted(self, dotted: str) -> None:
        """Follow "package.module.definition.attribute": the longest part that is a module."""
        self._note_package(dotted)
        if _finds_code(dotted):
            self._open_all()
        parts = dotted.split(".")
        for cut in range(len(parts), 0, -1):
            module = ".".join(parts[:cut])
            if self.tree.module(module):
                rest = parts[cut:]
                self._open.append((module, rest[0] if rest else _WHOLE))
                return

    def _note_package(self, dotted: str) -> None:
        top = dotted.partition(".")[0]
        if top not in self.tree.packages and top not in sys.stdlib_module_names:
            self.reached.packages.add(top)

    def _open_all(self) -> None:
        self._open += [(name, _WHOLE) for name in self.tree.names_below("nodes")]


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


class _WithoutText(ast.NodeTransformer):
    """Drops bare strings: docstrings of functions and classes, and those under fields."""

    def generic_visit(self, node: ast.AST) -> ast.AST:
        super().generic_visit(node)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            node.body = [s for s in node.body if not is_text(s)] or [ast.Pass()]
        return node


def _dotted(node: ast.Attribute) -> str:
    """Return "a.b.c" for an attribute chain on a plain name, else ""."""
    parts: list[str] = []
    inner: ast.expr = node
    while isinstance(inner, ast.Attribute):
        parts.append(inner.attr)
        inner = inner.value
    return ".".join([inner.id, *reversed(parts)]) if isinstance(inner, ast.Name) else ""


def _data_files(folder: Path) -> Iterator[Path]:
    """Yield what lies beside a module but is no Python: templates and scripts of pages.

    Sub-folders count unless they are packages, whose own modules answer for them.
    """
    for path in sorted(folder.iterdir()):
        if path.name.startswith(".") or path.name.endswith("~") or path.name == "__pycache__":
            continue
        if path.is_dir() and not (path / "__init__.py").exists():
            yield from _data_files(path)
        elif path.is_file() and path.suffix != ".py":
            yield path
