"""Artefacts by content, and records of which stage made them from what.

    objects/ab/abcd.../      the files of one artefact, in a folder named by their content hash
    records/ab/abcd....json  what a stage made, under the key of what it was made from
    scratch/                 work of processes that live; what a killed one left is swept
    locks/

A record is written after its objects are safe on disk, and both appear by one rename: at whatever
line a process dies, a record that exists stands for artefacts that exist.
"""

import json
import os
import secrets
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from catalog.locks import hold_lock, try_lock
from catalog.signatures import Signatures, hash_files, read_files
from nodes.errors import BadInput


class Damaged(Exception):
    """An object is gone, or its bytes are not those of its name; the argument is its hash."""


class StoreFailure(BadInput):
    """The disk refused to keep something."""

    exit_code = 4


@dataclass(frozen=True)
class Record:
    """What one stage made: `made_from` holds, part by part, all that the key is the hash of."""

    key: str
    stage: str
    made_from: dict[str, Any]
    outputs: dict[str, str]
    seconds: float
    made_at: str


class Store:
    """The store in one folder; any number of processes may use it at once."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.signatures = Signatures(root / "signatures.json")

    # Objects

    def object_path(self, content: str) -> Path:
        """Return the folder of an object."""
        return self.root / "objects" / content[:2] / content

    def is_intact(self, content: str, *, again: bool = False) -> bool:
        """Return whether an object is there with the bytes of its name."""
        return self.signatures.hash_path(self.object_path(content), again=again) == content

    def save_object(self, files: Mapping[str, bytes]) -> str:
        """Keep named bytes and return their content hash; all of them or none.

        Raises
        ------
        StoreFailure : if the disk is full or refuses; nothing half-written stays.
        """
        content = hash_files(files)
        if self.is_intact(content, again=True):
            return content
        try:
            with self.scratch() as scratch:
                _write_files(scratch / content, files)
                self._move_in(scratch, content)
        except OSError as error:
            raise StoreFailure(
                f"could not keep {sum(map(len, files.values())) / 1e6:.1f} MB: {error.strerror}",
                "the folder data/store must be writable and have room",
                "make room (`tendril clean` drops what no kept run uses) and run again",
            ) from error
        return content

    def load_object(self, content: str) -> dict[str, bytes]:
        """Return an object's files, every byte checked; a damaged one is put out of the way.

        Raises
        ------
        Damaged : if the object is gone or its bytes are not those of its name.
        """
        try:
            files = read_files(self.object_path(content))
        except OSError:
            files = {}
        if not files or hash_files(files) != content:
            self.discard_object(content)
            raise Damaged(content)
        return files

    def discard_object(self, content: str) -> None:
        """Take an object out of the store."""
        with self.scratch() as scratch:
            try:
                os.rename(self.object_path(content), scratch / "discarded")
            except FileNotFoundError:
                return

    def _move_in(self, scratch: Path, content: str) -> None:
        target = self.object_path(content)
        _make_durable_folder(target.parent)
        if target.exists():  # damaged, or another process was quicker with the same bytes
            os.rename(target, scratch / "replaced")
        try:
            os.rename(scratch / content, target)
        except OSError:
            if not self.is_intact(content, again=True):
                raise
        _sync(target.parent)

    # Records

    def read_record(self, key: str) -> Record | None:
        """Return the record of a key; None if there is none, or it is not what was written."""
        try:
            envelope = json.loads(self._record_path(key).read_bytes())
            if envelope["sha256"] != _checksum(envelope["record"]):
                return None
            return Record(**envelope["record"])
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def write_record(self, record: Record) -> None:
        """Make a record stand; its objects must be saved already."""
        fields = asdict(record)
        text = json.dumps({"record": fields, "sha256": _checksum(fields)}, indent=1)
        path = self._record_path(record.key)
        try:
            with self.scratch() as scratch:
                _write_files(scratch / "record", {path.name: text.encode()})
                _make_durable_folder(path.parent)
                os.replace(scratch / "record" / path.name, path)
                _sync(path.parent)
        except OSError as error:
            raise StoreFailure(
                f"could not note what {record.stage} made: {error.strerror}",
                "the folder data/store must be writable and have room",
                "make room and run again; the stage will be done once more",
            ) from error

    def _record_path(self, key: str) -> Path:
        return self.root / "records" / key[:2] / f"{key}.json"

    # Locks and leftovers

    def lock_key(self, key: str, waiting: Callable[[], None]) -> AbstractContextManager[None]:
        """Hold the right to compute a key, so that two runs share the work."""
        return hold_lock(self.root / "locks" / f"{key}.lock", waiting=waiting)

    def in_use(self) -> AbstractContextManager[None]:
        """Keep `clean` away while a run is at work."""
        return hold_lock(self.root / "locks" / "in_use.lock", shared=True)

    @contextmanager
    def scratch(self) -> Iterator[Path]:
        """Give a folder that is removed at the end, or swept by a later run if we are killed."""
        folder = self.root / "scratch" / f"{os.getpid()}-{secrets.token_hex(4)}"
        with hold_lock(folder.with_name(folder.name + ".lock")):
            folder.mkdir(parents=True)
            try:
                yield folder
            finally:
                shutil.rmtree(folder, ignore_errors=True)

    def sweep(self) -> None:
        """Remove what killed processes left: a lock that is free has lost its holder."""
        for name in {path.name.removesuffix(".lock") for path in self.root.glob("scratch/*")}:
            folder = self.root / "scratch" / name
            handle = try_lock(folder.with_name(f"{name}.lock"))
            if handle is not None:
                shutil.rmtree(folder, ignore_errors=True)
                folder.with_name(f"{name}.lock").unlink(missing_ok=True)
                os.close(handle)
        for lock in self.root.glob("locks/*.lock"):
            handle = try_lock(lock)
            if handle is not None:
                lock.unlink(missing_ok=True)
                os.close(handle)
        for stray in self.root.glob("*.json.*"):
            stray.unlink(missing_ok=True)

    def clean(self, kept_keys: set[str], *, dry_run: bool = False) -> tuple[int, int]:
        """Drop every record but the kept ones and every object that none of those names.

        Returns
        -------
        Number of artefacts dropped, and their bytes.

        Raises
        ------
        StoreFailure : if a run is at work.
        """
        handle = try_lock(self.root / "locks" / "in_use.lock")
        if handle is None:
            raise StoreFailure(
                "a run is at work in this store",
                "artefacts are dropped only while nothing uses them",
                "wait until it ends, then clean again",
            )
        try:
            return self._drop_all_but(kept_keys, dry_run)
        finally:
            os.close(handle)

    def _drop_all_but(self, kept_keys: set[str], dry_run: bool) -> tuple[int, int]:
        self.sweep()
        kept = {key: record for key in kept_keys if (record := self.read_record(key))}
        used = {content for record in kept.values() for content in record.outputs.values()}
        if not dry_run:  # records first: what has no record is not done, so a kill here is harmless
            for path in self.root.glob("records/*/*.json"):
                if path.stem not in kept:
                    path.unlink()
        unused = [path for path in self.root.glob("objects/*/*") if path.name not in used]
        size = sum(f.stat().st_size for path in unused for f in path.rglob("*") if f.is_file())
        if not dry_run:
            for path in unused:
                self.discard_object(path.name)
            self.signatures.forget()
        return len(unused), size


def _write_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files through to the disk, read-only, so that no tool changes them by accident."""
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(path, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        path.chmod(0o444)
    for path in [folder, *(p for p in folder.rglob("*") if p.is_dir())]:
        _sync(path)


def _make_durable_folder(folder: Path) -> None:
    if not folder.is_dir():
        folder.mkdir(parents=True, exist_ok=True)
        _sync(folder.parent)


def _sync(folder: Path) -> None:
    """Make renames in a folder survive a power cut."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _checksum(fields: Mapping[str, Any]) -> str:
    return sha256(json.dumps(fields, sort_keys=True).encode()).hexdigest()
