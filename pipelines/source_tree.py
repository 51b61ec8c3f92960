"""What a function reaches in the project's source, found by reading it, never by importing it.

A definition is a function, a class or an assignment at the top of a module. From the function's
own, every name is followed to the definition that it means, in the same module or through imports
(also those inside functions). What cannot be followed counts as everything: a module passed about
as a value counts whole, `exec` and its like make all of `nodes` count. Comments, docstrings and
layout do not count; statements that run when a module is imported do.
"""

import ast
import copy
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from hashlib import sha256
from pathlib import Path

_UNFOLLOWABLE = {"exec", "eval", "__import__", "import_module", "globals", "vars"}
_WHOLE = "*"


@dataclass
class Reach:
    """What a function reaches: hashes of definitions and files by name, and packages imported."""

    definitions: dict[str, str] = field(default_factory=dict)
    packages: set[str] = field(default_factory=set)


@dataclass(frozen=True)
class Signature:
    """What a function's source says of it."""

    summary: str
    arguments: tuple[str, ...]
    takes_more: bool
    parameters_type: str


class Module:
    """The source of one module, taken apart."""

    def __init__(self, name: str, path: Path) -> None:
        self.name, self.path = name, path
        self.is_package = path.name == "__init__.py"
        tree = ast.parse(path.read_bytes(), filename=str(path))
        self.definitions: dict[str, list[ast.stmt]] = {}
        self.at_import: list[ast.stmt] = []
        self.imports: dict[str, str] = {}
        self.stars: list[str] = []
        for statement in tree.body:
            self._sort_in(statement)

    def _sort_in(self, statement: ast.stmt) -> None:
        if isinstance(statement, ast.Import | ast.ImportFrom):
            self.imports |= self.imported_names(statement)
            if isinstance(statement, ast.ImportFrom) and statement.names[0].name == "*":
                self.stars.append(self._source_of(statement))
        elif names := list(_defined_names(statement)):
            for name in names:
                self.definitions.setdefault(name, []).append(statement)
        elif not _is_text(statement):
            self.at_import.append(statement)
            for inner in ast.walk(statement):
                if isinstance(inner, ast.Import | ast.ImportFrom):
                    self.imports |= self.imported_names(inner)
                elif isinstance(inner, ast.stmt):
                    for name in _defined_names(inner):
                        self.definitions.setdefault(name, []).append(statement)

    def imported_names(self, statement: ast.Import | ast.ImportFrom) -> dict[str, str]:
        """Return local name -> dotted name of what an import statement brings."""
        if isinstance(statement, ast.ImportFrom):
            source = self._source_of(statement)
            return {a.asname or a.name: f"{source}.{a.name}" for a in statement.names}
        return {
            alias.asname or alias.name.partition(".")[0]: alias.name
            if alias.asname
            else alias.name.partition(".")[0]
            for alias in statement.names
        }

    def _source_of(self, statement: ast.ImportFrom) -> str:
        if not statement.level:
            return statement.module or ""
        parts = self.name.split(".")
        keep = len(parts) - statement.level + self.is_package
        return ".".join(parts[:keep] + ([statement.module] if statement.module else []))

    @cached_property
    def reads_docstrings(self) -> bool:
        """Return whether the module looks at docstrings, so that they count."""
        return b"__doc__" in self.path.read_bytes()


class SourceTree:
    """The project's own modules under a root folder."""

    def __init__(self, root: Path, packages: tuple[str, ...] = ("nodes", "catalog")) -> None:
        self.root, self.packages = root, packages
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
        return _read_signature(found[0])

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
                return Module(name, path)
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
        self._entered: set[str] = set()

    def follow(self, module: str, name: str) -> Reach:
        self._open.append((module, name))
        seen: set[tuple[str, str]] = set()
        while self._open:
            place = self._open.pop()
            if place not in seen:
                seen.add(place)
                self._visit(*place)
        return self.reached

    def _visit(self, module_name: str, name: str) -> None:
        module = self.tree.module(module_name)
        if module is None:
            return
        self._enter(module)
        if name == _WHOLE:
            self._open += [(module_name, other) for other in module.definitions]
            for dotted in module.imports.values():
                self._follow_dotted(dotted)
            return
        for order, statement in enumerate(module.definitions.get(name, ())):
            self._count(f"{module_name}.{name}" + (f"~{order}" if order else ""), module, statement)
        if name not in module.definitions:
            if name in module.imports:
                self._follow_dotted(module.imports[name])
            for star in module.stars:
                self._open.append((star, name))

    def _enter(self, module: Module) -> None:
        """Count what importing a module runs, in it and in the packages around it."""
        if module.name in self._entered:
            return
        self._entered.add(module.name)
        for order, statement in enumerate(module.at_import):
            self._count(f"{module.name}.<import>{order}", module, statement)
        for star in module.stars:
            self._open.append((star, _WHOLE))
        for file in _data_files(module.path.parent) if module.name.startswith("nodes.") else ():
            name = str(file.relative_to(self.tree.root))
            self.reached.definitions[name] = sha256(file.read_bytes()).hexdigest()
        parent = self.tree.module(module.name.rpartition(".")[0])
        if parent:
            self._enter(parent)

    def _count(self, name: str, module: Module, statement: ast.stmt) -> None:
        if not module.reads_docstrings:
            statement = _WithoutText().visit(copy.deepcopy(statement))
        self.reached.definitions[name] = sha256(ast.dump(statement).encode()).hexdigest()
        names = dict(module.imports)
        for inner in ast.walk(statement):
            if isinstance(inner, ast.Import | ast.ImportFrom):
                names |= module.imported_names(inner)
        self._follow_names(statement, module, names)

    def _follow_names(self, statement: ast.stmt, module: Module, names: dict[str, str]) -> None:
        bases = set()
        for inner in ast.walk(statement):
            if isinstance(inner, ast.Attribute) and (dotted := _dotted(inner)):
                bases.add(id(_base(inner)))
                self._follow_name(dotted, module, names)
        for inner in ast.walk(statement):
            if isinstance(inner, ast.Name) and id(inner) not in bases:
                self._follow_name(inner.id, module, names)

    def _follow_name(self, dotted: str, module: Module, names: dict[str, str]) -> None:
        first, _, rest = dotted.partition(".")
        if _UNFOLLOWABLE & set(dotted.split(".")):
            self._open += [(name, _WHOLE) for name in self.tree.names_below("nodes")]
        if first in names:
            self._follow_dotted(names[first] + (f".{rest}" if rest else ""))
        if first in module.definitions:
            self._open.append((module.name, first))
        elif first not in names:
            self._open += [(star, first) for star in module.stars]

    def _follow_dotted(self, dotted: str) -> None:
        """Follow "package.module.definition.attribute": the longest part that is a module."""
        top = dotted.partition(".")[0]
        if top not in self.tree.packages:
            if top not in sys.stdlib_module_names:
                self.reached.packages.add(top)
            elif dotted.rpartition(".")[2] in _UNFOLLOWABLE:
                self._open += [(name, _WHOLE) for name in self.tree.names_below("nodes")]
            return
        parts = dotted.split(".")
        for cut in range(len(parts), 0, -1):
            module = ".".join(parts[:cut])
            if self.tree.module(module):
                rest = parts[cut:]
                self._open.append((module, rest[0] if rest else _WHOLE))
                return


def _defined_names(statement: ast.stmt) -> Iterator[str]:
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        yield statement.name
    elif isinstance(statement, ast.Assign | ast.AnnAssign | ast.AugAssign):
        targets = statement.targets if isinstance(statement, ast.Assign) else None
        one = getattr(statement, "target", None) or getattr(statement, "name", None)
        for target in targets or [one]:
            yield from (n.id for n in ast.walk(target) if isinstance(n, ast.Name))


def _is_text(statement: ast.stmt) -> bool:
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )


class _WithoutText(ast.NodeTransformer):
    """Drops bare strings: docstrings of functions and classes, and those under fields."""

    def generic_visit(self, node: ast.AST) -> ast.AST:
        super().generic_visit(node)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            node.body = [s for s in node.body if not _is_text(s)] or [ast.Pass()]
        return node


def _base(node: ast.expr) -> ast.expr:
    while isinstance(node, ast.Attribute):
        node = node.value
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


def _read_signature(function: ast.FunctionDef) -> Signature:
    arguments = function.args.args + function.args.kwonlyargs
    types = {a.arg: ast.unparse(a.annotation) if a.annotation else "" for a in arguments}
    parameters_type = types.pop("parameters", "")
    summary = (ast.get_docstring(function) or "").partition("\n")[0]
    return Signature(summary, tuple(types), bool(function.args.vararg), parameters_type)
