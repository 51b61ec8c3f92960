"""At whatever line a save ends, what counts as done is done and whole."""

import errno
import fcntl
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import catalog.locks
import catalog.signatures
import catalog.store
from catalog.signatures import hash_files
from catalog.store import Damaged, Record, Store, StoreFailure

FILES = {"a.bin": b"first" * 100, "folder/b.bin": b"second" * 50}
CONTENT = hash_files(FILES)
KEY = "ab" * 32
WATCHED = {m.__file__ for m in (catalog.store, catalog.locks, catalog.signatures)}


def save_all(root: Path) -> None:
    """Save one artefact and its record, as the engine does."""
    store = Store(root)
    store.sweep()
    with store.lock_key(KEY, lambda: None):
        content = store.save_object(FILES)
        record = Record(KEY, "stage", {"parameters": {}}, {"made": content}, 0.1, "2000-01-01")
        store.write_record(record)
    store.signatures.save()


def at_line(number: int, act: Callable[[], None]) -> Callable:
    """Return a trace function that acts at the n-th line run in the store's own modules."""
    left = [number]

    def trace(frame, event, argument):
        if frame.f_code.co_filename not in WATCHED:
            return None
        if event == "line":
            left[0] -= 1
            if left[0] == 0:
                sys.settrace(None)
                act()
        return trace

    return trace


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def fill_disk() -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def check_what_stands(root: Path) -> None:
    """A record that is there stands for artefacts that are there, and a rerun completes."""
    record = Store(root).read_record(KEY)
    if record:
        assert Store(root).load_object(record.outputs["made"]) == FILES
    save_all(root)
    record = Store(root).read_record(KEY)
    assert record is not None
    assert record.outputs == {"made": CONTENT}
    assert Store(root).load_object(CONTENT) == FILES
    left = [
        path.name for place in ("scratch/*", "locks/*", "*.json.*") for path in root.glob(place)
    ]
    assert left == []


def end_at_every_line(folder: Path, act: Callable[[], None]) -> int:
    """Save in a process of its own for each line, act there, check what stands; count the lines."""
    ended = 0
    while True:
        root = folder / str(ended)
        child = os.fork()
        if child == 0:
            code = 99  # whatever else happens, the child must not go on with the test's own code
            try:
                sys.settrace(at_line(ended + 1, act))
                save_all(root)
                code = sys.gettrace() is None
            except (OSError, StoreFailure):
                code = 1
            finally:
                os._exit(code)
        _, status = os.waitpid(child, 0)
        assert os.waitstatus_to_exitcode(status) in (0, 1, -signal.SIGKILL)
        check_what_stands(root)
        if status == 0:
            return ended
        ended += 1


@pytest.mark.parametrize("act", [die, fill_disk])
def test_a_save_that_ends_at_any_line_leaves_nothing_half_done(
    tmp_path: Path, act: Callable[[], None]
) -> None:
    assert end_at_every_line(tmp_path, act) > 100


def test_a_full_disk_is_told_with_cure(tmp_path: Path) -> None:
    import resource

    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200))
        try:
            Store(tmp_path).save_object(FILES)
        except StoreFailure as error:
            os._exit(error.exit_code if "tendril clean" in error.cure else 9)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == StoreFailure.exit_code
    assert not Store(tmp_path).object_path(CONTENT).exists()


@settings(max_examples=30, deadline=None)
@given(
    st.dictionaries(
        st.text("abc/", min_size=1).map(lambda s: "f" + s.replace("/", "") + "/g"),
        st.binary(max_size=50),
        min_size=1,
        max_size=4,
    )
)
def test_what_is_saved_is_loaded(tmp_path_factory: pytest.TempPathFactory, files: dict) -> None:
    store = Store(tmp_path_factory.mktemp("store"))
    content = store.save_object(files)
    assert store.is_intact(content)
    assert store.load_object(content) == files
    assert store.save_object(files) == content


def test_saving_mends_a_damaged_object(tmp_path: Path) -> None:
    store = Store(tmp_path)
    content = store.save_object(FILES)
    path = store.object_path(content) / "a.bin"
    path.chmod(0o644)
    path.write_bytes(b"other")
    assert not store.is_intact(content)
    store.save_object(FILES)
    assert store.load_object(content) == FILES


def test_loading_a_damaged_object_discards_it(tmp_path: Path) -> None:
    store = Store(tmp_path)
    content = store.save_object(FILES)
    path = store.object_path(content) / "a.bin"
    path.chmod(0o644)
    path.write_bytes(b"other")
    with pytest.raises(Damaged):
        store.load_object(content)
    assert not store.object_path(content).exists()


def test_objects_are_read_only(tmp_path: Path) -> None:
    store = Store(tmp_path)
    folder = store.object_path(store.save_object(FILES))
    assert all(not f.stat().st_mode & 0o222 for f in folder.rglob("*") if f.is_file())


def test_clean_keeps_what_kept_records_use_and_nothing_else(tmp_path: Path) -> None:
    store = Store(tmp_path)
    kept, dropped = store.save_object({"x": b"1"}), store.save_object({"x": b"2"})
    store.write_record(Record("k" * 64, "s", {}, {"made": kept}, 0.0, ""))
    store.write_record(Record("d" * 64, "s", {}, {"made": dropped}, 0.0, ""))
    assert store.clean({"k" * 64}, dry_run=True) == (1, 1)
    assert store.is_intact(dropped)
    assert store.clean({"k" * 64}) == (1, 1)
    assert store.is_intact(kept) and not store.is_intact(dropped)
    assert store.read_record("k" * 64) and not store.read_record("d" * 64)


def test_clean_is_refused_while_a_run_is_at_work(tmp_path: Path) -> None:
    store = Store(tmp_path)
    with store.in_use(), pytest.raises(StoreFailure, match="at work"):
        store.clean(set())
    store.clean(set())


def test_a_lock_is_free_again_when_its_holder_is_killed(tmp_path: Path) -> None:
    path = tmp_path / "x.lock"
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        catalog.locks.try_lock(path)
        os.write(writer, b"held")
        signal.pause()
    os.read(reader, 4)
    assert catalog.locks.try_lock(path) is None
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    handle = catalog.locks.try_lock(path)
    assert handle is not None
    fcntl.flock(handle, fcntl.LOCK_UN)
    os.close(handle)
