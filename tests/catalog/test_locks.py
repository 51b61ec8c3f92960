"""A lock has one holder, waits for no dead one, and leaves nothing behind."""

import os
import threading
import time
from pathlib import Path

import pytest

from catalog.locks import hold_lock, try_lock


def test_a_held_lock_is_refused_and_then_free(tmp_path: Path) -> None:
    path = tmp_path / "folder" / "x.lock"
    with hold_lock(path):
        assert try_lock(path) is None
    assert not path.exists()
    handle = try_lock(path)
    assert handle is not None
    os.close(handle)


def test_a_lock_is_let_go_after_an_error(tmp_path: Path) -> None:
    with pytest.raises(KeyError), hold_lock(tmp_path / "x"):
        raise KeyError
    with hold_lock(tmp_path / "x", waiting=lambda: pytest.fail("it was still held")):
        pass


def test_who_waits_is_told_once_and_comes_next(tmp_path: Path) -> None:
    path, told, order = tmp_path / "x", [], []

    def wait() -> None:
        with hold_lock(path, waiting=lambda: told.append(1)):
            order.append("second")

    with hold_lock(path):
        other = threading.Thread(target=wait)
        other.start()
        while not told:
            time.sleep(0.01)
        order.append("first")
    other.join(5)
    assert (told, order) == ([1], ["first", "second"])


def test_shared_holders_do_not_shut_each_other_out(tmp_path: Path) -> None:
    path = tmp_path / "x"
    with hold_lock(path, shared=True), hold_lock(path, shared=True, waiting=pytest.fail):
        assert try_lock(path) is None
    handle = try_lock(path)
    assert handle is not None
    os.close(handle)


def test_many_processes_never_hold_one_lock_together(tmp_path: Path) -> None:
    """Each adds to a file by reading and writing it, which loses counts if two do it at once."""
    path, count = tmp_path / "x", tmp_path / "count"
    count.write_text("0")
    children = []
    for _ in range(6):
        child = os.fork()
        if child == 0:
            for _ in range(50):
                with hold_lock(path):
                    count.write_text(str(int(count.read_text()) + 1))
            os._exit(0)
        children.append(child)
    assert [os.waitpid(child, 0)[1] for child in children] == [0] * 6
    assert count.read_text() == "300"
