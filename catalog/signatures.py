"""Content hashes of files and folders, recomputed only where something touched them.

A path's signature is the name, size, inode, and times of modification and of status change of
every file in it. The last cannot be set by a program, so a changed byte shows even where a tool
restores the time of modification. What changes without any program (a failing disk) is caught
when an artefact is loaded: the store hashes all that it reads.
"""

import hashlib
import os
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

from catalog.memory import recall, remember

# Clocks of file systems tick in steps of up to a second: a file that changed less than this before
# it was hashed might change again within the same tick, so such a hash is not trusted next time.
_TICK_NS = 1_000_000_000
_CHUNK = 1 << 20


def hash_files(files: Mapping[str, bytes]) -> str:
    """Return the content hash of named bytes: SHA-256 over every name and its file's SHA-256."""
    return _hash_names({name: hashlib.sha256(data).hexdigest() for name, data in files.items()})


class Signatures:
    """Remembers hash and signature of paths in one JSON file; losing it costs only time."""

    def __init__(self, memory: Path) -> None:
        self._memory = memory
        self._known = recall(memory)
        self._changed = False

    def hash_path(self, path: Path, *, again: bool = False) -> str | None:
        """Return the content hash of a file or folder, None if it does not exist.

        `again` reads every byte even where the signature says that nothing changed.
        """
        try:
            files = dict(_list_files(path))
            stats = {name: os.stat(file) for name, file in files.items()}
            signature = _sign(stats)
            match self._known.get(_name_of(path)):
                case [str(digest), str(before), True] if before == signature and not again:
                    return digest
            return self._remember(path, files, stats, signature) if files else None
        except FileNotFoundError:  # gone while we looked
            return None

    def _remember(self, path: Path, files: dict, stats: dict, signature: str) -> str:
        started = time.time_ns()
        digest = _hash_names({name: _hash_file(file) for name, file in files.items()})
        settled = max(s.st_ctime_ns for s in stats.values()) + _TICK_NS < started
        self._known[_name_of(path)] = [digest, signature, settled]
        self._changed = True
        return digest

    def forget(self) -> None:
        """Drop all that is remembered."""
        self._known.clear()
        self._memory.unlink(missing_ok=True)

    def save(self) -> None:
        """Write what was learnt; a full disk or a lost race costs nothing but a later rehash."""
        if not self._changed:
            return
        remember(self._memory, self._known)
        self._changed = False


def _name_of(path: Path) -> str:
    """Return the key of a path: hashed, since folders of images are often named after patients."""
    return hashlib.sha256(os.fsencode(path)).hexdigest()


def _list_files(path: Path) -> Iterator[tuple[str, str]]:
    """Yield (relative name, path) of a file, or of every file below a folder but hidden ones.

    Links count as what they point to, but for those that lead back to where they lie in.
    """
    if path.is_file():
        yield path.name, str(path)
        return
    for folder, folders, names in os.walk(path, onerror=_tell, followlinks=True):
        folders[:] = sorted(f for f in folders if not f.startswith(".") and not _is_loop(folder, f))
        for name in names:
            file = os.path.join(folder, name)
            if not name.startswith(".") and not _is_no_file(file):
                yield os.path.relpath(file, path), file


def _tell(error: OSError) -> None:
    """Raise what `os.walk` would pass over: a folder that cannot be read is not an empty one."""
    if not isinstance(error, FileNotFoundError | NotADirectoryError):
        raise error


def _is_no_file(path: str) -> bool:
    """Return whether a path is a pipe, a socket or a device, which have no content to hash."""
    return os.path.exists(path) and not os.path.isfile(path)


def _is_loop(folder: str, name: str) -> bool:
    inner = os.path.join(folder, name)
    if not os.path.islink(inner):
        return False
    return Path(os.path.realpath(folder)).is_relative_to(os.path.realpath(inner))


def read_files(path: Path) -> dict[str, bytes]:
    """Return the bytes of a file, or of every file below a folder, by relative name."""
    return {name: Path(file).read_bytes() for name, file in _list_files(path)}


def _hash_file(file: str) -> str:
    digest = hashlib.sha256()
    with open(file, "rb") as stream:
        while chunk := stream.read(_CHUNK):
            digest.update(chunk)
    return digest.hexdigest()


def _hash_names(digests: Mapping[str, str]) -> str:
    lines = (f"{name}\0{digests[name]}\n" for name in sorted(digests))
    return hashlib.sha256("".join(lines).encode("utf-8", "surrogateescape")).hexdigest()


def _sign(stats: Mapping[str, os.stat_result]) -> str:
    rows = [
        (name, s.st_size, s.st_ino, s.st_mtime_ns, s.st_ctime_ns)
        for name, s in sorted(stats.items())
    ]
    return hashlib.sha256(repr(rows).encode("utf-8", "surrogateescape")).hexdigest()
