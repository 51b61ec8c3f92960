"""The Prefect server that a run reports to: the one in PREFECT_API_URL, or one inside our process.

A server of our own is a thread, so it cannot outlive the program, however that is killed. Its
database lies in data/prefect; it tells nobody outside.
"""

import os
import signal
import socket
import sqlite3
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any
from urllib.request import urlopen

from catalog.locks import hold_lock
from catalog.store import StoreFailure
from nodes.errors import BadInput

_QUIET = {
    "DO_NOT_TRACK": "1",
    "PREFECT_SERVER_ANALYTICS_ENABLED": "false",
    "PREFECT_LOGGING_TO_API_ENABLED": "false",
    "PREFECT_SERVER_LOGGING_LEVEL": "ERROR",
    "PREFECT_CLI_PROMPT": "false",
}
_START_SECONDS = 120
_INTERRUPTS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def prefect_server(data: Path, *, schedules: bool = False) -> Iterator[str]:
    """Make sure that a server answers while the block runs; yield the address of its interface.

    Parameters
    ----------
    data : the project's data folder, where Prefect's own data go.
    schedules : whether a server of our own must also start scheduled runs.
    """
    home = data / "prefect"
    # A run tells its errors itself, and Prefect would tell them a second time.
    level = "WARNING" if schedules else "CRITICAL"
    for name, value in {
        **_QUIET, "PREFECT_HOME": str(home), "PREFECT_LOGGING_LEVEL": level,
    }.items():  # fmt: skip
        os.environ.setdefault(name, value)
    if address := os.environ.get("PREFECT_API_URL"):
        _check_answers(address)
        yield address
        return
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        address = f"http://127.0.0.1:{listener.getsockname()[1]}/api"
        os.environ["PREFECT_API_URL"] = address
        try:
            # Two servers at their first start would both lay out the same database.
            with hold_lock(home / "start.lock"), _interrupts_later():
                _put_damaged_database_aside(home / "prefect.db")
                server, thread = _start(listener, schedules)
            yield address
        finally:
            del os.environ["PREFECT_API_URL"]
        server.should_exit = True
        thread.join(timeout=5)


def _check_answers(address: str) -> None:
    """Refuse a server that does not answer, before any work is done."""
    try:
        with urlopen(f"{address.rstrip('/')}/health", timeout=10):
            return
    except (OSError, ValueError) as error:
        raise BadInput(
            f"PREFECT_API_URL={address}: {error}",
            "the server that it names must answer",
            "start it, unset PREFECT_API_URL, or run with --no-prefect",
        ) from error


@contextmanager
def _interrupts_later() -> Iterator[None]:
    """Hold Ctrl-C back while the server's thread starts: half started, it cannot be stopped."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = {n: signal.signal(n, lambda n, _: came.append(n)) for n in _INTERRUPTS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if came:
        raise KeyboardInterrupt


def _put_damaged_database_aside(database: Path) -> None:
    """Start with an empty database where the old one cannot be read: it is only a log."""
    if not database.exists():
        return
    try:
        with closing(sqlite3.connect(database)) as connection:
            connection.execute("select count(*) from sqlite_master").fetchall()
    except sqlite3.DatabaseError:
        os.replace(database, database.with_name("damaged.db"))
        for rest in database.parent.glob(f"{database.name}-*"):
            rest.unlink(missing_ok=True)


def _start(listener: socket.socket, schedules: bool) -> tuple[Any, threading.Thread]:
    import uvicorn
    from prefect.server.api.server import create_app

    app = create_app(ephemeral=not schedules)
    server = uvicorn.Server(uvicorn.Config(app, log_level="critical", lifespan="on"))
    thread = threading.Thread(target=server.run, args=([listener],), daemon=True)
    thread.start()
    end = time.monotonic() + _START_SECONDS
    while not server.started:
        if time.monotonic() > end or not thread.is_alive():
            raise StoreFailure(
                "Prefect's own server did not start",
                f"it must answer within {_START_SECONDS} s and be able to write in data/prefect",
                "see that the disk has room, or run with --no-prefect",
            )
        time.sleep(0.02)
    return server, thread
