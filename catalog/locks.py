"""Locks between processes that the kernel lets go of when their holder dies, however it dies."""

import fcntl
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def hold_lock(
    path: Path, *, shared: bool = False, waiting: Callable[[], None] = lambda: None
) -> Iterator[None]:
    """Hold the lock of that name until the block ends; `waiting` is called once if it must wait.

    An exclusive holder removes the file when it lets go, so locks leave nothing behind.
    """
    kind = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
    handle = try_lock(path, kind)
    if handle is None:
        waiting()
        handle = _wait_for_lock(path, kind)
    try:
        yield
    finally:
        try:
            if not shared:
                path.unlink(missing_ok=True)
        finally:
            os.close(handle)


def try_lock(path: Path, kind: int = fcntl.LOCK_EX) -> int | None:
    """Return the open lock file if the lock was free, else None; close it to let go."""
    return _open_locked(path, kind | fcntl.LOCK_NB)


def _wait_for_lock(path: Path, kind: int) -> int:
    while (handle := _open_locked(path, kind)) is None:
        pass
    return handle


def _open_locked(path: Path, operation: int) -> int | None:
    path.parent.mkdir(parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(handle, operation)
        # A former holder may have removed the file between our opening and locking it: then we
        # hold a lock that nobody else can see.
        if os.path.samestat(os.fstat(handle), os.stat(path)):
            return handle
    except (BlockingIOError, FileNotFoundError):
        pass
    except BaseException:
        os.close(handle)
        raise
    os.close(handle)
    return None
