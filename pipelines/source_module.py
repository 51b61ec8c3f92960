"""The source of one module, taken apart: definitions, imports, what runs at import."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

_READS_TEXT = (b"__doc__", b"getdoc", b"getsource", b"model_fields", b"model_json_schema")


@dataclass(frozen=True)
class Signature:
    """What a function's source says of it."""

    summary: str
    arguments: tuple[str, ...]
    takes_more: bool
    parameters_type: str


class Module:
    """The source of one module, taken apart."""

    def __init__(
        self, name: str, path: Path, packages: tuple[str, ...], source: bytes | None = None
    ) -> None:
        self.name, self.path, self._packages = name, path, packages
        self.is_package = path.name == "__init__.py"
        source = path.read_bytes() if source is None else source
        tree = ast.parse(source, filename=str(path))
        # Whether the module may look at docstrings or source, so that they count.
        self.reads_docstrings = any(word in source for word in _READS_TEXT)
        self.definitions: dict[str, list[ast.stmt]] = {}
        self.at_import: list[ast.stmt] = []
        self.imports_run: list[ast.Import | ast.ImportFrom] = []
        self.meanings: dict[str, list[str]] = {}
        self.stars: list[str] = []
        self.texts = "".join(ast.dump(s) for s in tree.body if is_text(s))
        for statement in tree.body:
            self._sort_in(statement)

    @property
    def imports(self) -> dict[str, str]:
        """Local name -> dotted name that it means, the last where several imports bring it."""
        return {name: dotted[-1] for name, dotted in self.meanings.items()}

    def _sort_in(self, statement: ast.stmt) -> None:
        if isinstance(statement, ast.Import | ast.ImportFrom):
            self._sort_in_import(statement)
            self.imports_run.append(statement)
        elif names := list(_defined_names(statement)):
            for name in names:
                self.definitions.setdefault(name, []).append(statement)
            if self._acts_elsewhere(statement):
                self.at_import.append(statement)
        elif not is_text(statement):
            self._sort_in_block(statement)

    def _sort_in_block(self, block: ast.stmt) -> None:
        """Sort in a statement that holds others: `if`, `try`, `for`, `with`; or an expression."""
        runs = not _is_for_type_checkers(block)
        if runs:
            self.at_import.append(block)
        for inner in ast.walk(block):
            if isinstance(inner, ast.Import | ast.ImportFrom):
                self._sort_in_import(inner)
                self.imports_run += [inner] * runs
            elif isinstance(inner, ast.stmt):
                for name in _defined_names(inner):
                    self.definitions.setdefault(name, []).append(block)

    def _sort_in_import(self, statement: ast.Import | ast.ImportFrom) -> None:
        for name, dotted in self.imported_names(statement).items():
            self.meanings.setdefault(name, []).append(dotted)
        if isinstance(statement, ast.ImportFrom) and statement.names[0].name == "*":
            self.stars.append(self._source_of(statement))

    def _acts_elsewhere(self, statement: ast.stmt) -> bool:
        """Return whether a definition may change what other modules hold."""
        if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            names = (n.id for d in statement.decorator_list for n in ast.walk(d) if _is_name(n))
            return any(name in self.definitions or self._is_ours(name) for name in names)
        return any(self._is_ours(name) for name in _defined_names(statement))

    def _is_ours(self, name: str) -> bool:
        """Return whether an imported name is the project's own."""
        return any(d.partition(".")[0] in self._packages for d in self.meanings.get(name, ()))

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

    def loaded_by(self, statement: ast.Import | ast.ImportFrom) -> list[str]:
        """Return the dotted names that an import statement may load as modules."""
        if isinstance(statement, ast.Import):
            return [alias.name for alias in statement.names]
        return list(self.imported_names(statement).values())

    def _source_of(self, statement: ast.ImportFrom) -> str:
        if not statement.level:
            return statement.module or ""
        parts = self.name.split(".")
        keep = len(parts) - statement.level + self.is_package
        return ".".join(parts[:keep] + ([statement.module] if statement.module else []))


def read_signature(function: ast.FunctionDef) -> Signature:
    """Return what a function's definition says of it."""
    arguments = function.args.args + function.args.kwonlyargs
    types = {a.arg: ast.unparse(a.annotation) if a.annotation else "" for a in arguments}
    parameters_type = types.pop("parameters", "")
    summary = (ast.get_docstring(function) or "").partition("\n")[0]
    return Signature(summary, tuple(types), bool(function.args.vararg), parameters_type)


def _is_name(node: ast.AST) -> bool:
    return isinstance(node, ast.Name)


def _is_for_type_checkers(statement: ast.stmt) -> bool:
    """Return whether the statement is an `if TYPE_CHECKING:`, whose body never runs."""
    if not isinstance(statement, ast.If) or statement.orelse:
        return False
    return ast.unparse(statement.test).rpartition(".")[2] == "TYPE_CHECKING"


def _defined_names(statement: ast.stmt) -> Iterator[str]:
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        yield statement.name
    elif isinstance(statement, ast.Assign | ast.AnnAssign | ast.AugAssign):
        targets = statement.targets if isinstance(statement, ast.Assign) else None
        one = getattr(statement, "target", None) or getattr(statement, "name", None)
        for target in targets or [one]:
            yield from (n.id for n in ast.walk(target) if isinstance(n, ast.Name))


def is_text(statement: ast.stmt) -> bool:
    """Return whether a statement is a bare string: a docstring, or a text under a field."""
    return (
        isinstance(statement, ast.Expr)
        and isinstance(statement.value, ast.Constant)
        and isinstance(statement.value.value, str)
    )
