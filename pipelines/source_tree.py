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
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

from pipelines.source_links import WHOLE, LinkReader, Links
from pipelines.source_module import Module, Signature, is_text, read_signature


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
        self._hashes: dict[tuple[str, bool], str] = {}
        self._data_files: dict[Path, dict[str, str]] = {}
        self.links = LinkReader(self)

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

    def hash_of(self, name: str, statement: ast.stmt, with_text: bool) -> str:
        """Return the hash of the statement called `name`, with its docstrings or without."""
        if (name, with_text) not in self._hashes:
            told = statement if with_text else _WithoutText().visit(copy.deepcopy(statement))
            self._hashes[name, with_text] = sha256(ast.dump(told).encode()).hexdigest()
        return self._hashes[name, with_text]

    def data_files(self, folder: Path) -> dict[str, str]:
        """Return the hash of each file beside the modules of a folder that is no Python."""
        if folder not in self._data_files:
            self._data_files[folder] = {
                str(file.relative_to(self.root)): sha256(file.read_bytes()).hexdigest()
                for file in _data_files(folder)
            }
        return self._data_files[folder]

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
            hashes[name] = self.tree.hash_of(name, statement, with_text)
        for module in self._entered.values() if with_text else ():
            hashes[f"{module.name}.<text>"] = sha256(module.texts.encode()).hexdigest()

    def _visit(self, module_name: str, name: str) -> None:
        module = self.tree.module(module_name)
        if module is None:
            return
        self._enter(module)
        self._count_data_files(module)
        if name in (WHOLE, "__dict__"):
            self._open += [(module_name, other) for other in module.definitions]
            self._open += [(star, WHOLE) for star in module.stars]
            self._follow(self.tree.links.of_name(module, WHOLE))
            return
        for order, statement in enumerate(module.definitions.get(name, ())):
            self._count(f"{module_name}.{name}" + (f"~{order}" if order else ""), module, statement)
        self._follow(self.tree.links.of_name(module, name))
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
        if module.name.startswith("nodes."):
            self.reached.definitions |= self.tree.data_files(module.path.parent)

    def _count(self, name: str, module: Module, statement: ast.stmt) -> None:
        self._counted[name] = statement
        self._follow(self.tree.links.of_statement(name, module, statement))

    def _follow(self, links: Links) -> None:
        self._open += links.opened
        self.reached.packages |= links.packages
        for dotted in links.entered:
            self._enter_all(dotted)
        if links.is_unfollowable:
            self._open_all()

    def _open_all(self) -> None:
        self._open += [(name, WHOLE) for name in self.tree.names_below("nodes")]


class _WithoutText(ast.NodeTransformer):
    """Drops bare strings: docstrings of functions and classes, and those under fields."""

    def generic_visit(self, node: ast.AST) -> ast.AST:
        super().generic_visit(node)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            node.body = [s for s in node.body if not is_text(s)] or [ast.Pass()]
        return node


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
