"""The Prefect server that a run reports to: the one in PREFECT_API_URL, or one inside our process.

A server of our own is a thread, so it cannot outlive the program, however that is killed. Its
database lies in data/prefect; it tells nobody outside.
"""

import os
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from catalog.locks import hold_lock
from nodes.errors import BadInput

_QUIET = {
    "DO_NOT_TRACK": "1",
    "PREFECT_SERVER_ANALYTICS_ENABLED": "false",
    "PREFECT_LOGGING_TO_API_ENABLED": "false",
    "PREFECT_SERVER_LOGGING_LEVEL": "ERROR",
    "PREFECT_CLI_PROMPT": "false",
}
_START_SECONDS = 120


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
        yield address
        return
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        address = f"http://127.0.0.1:{listener.getsockname()[1]}/api"
        os.environ["PREFECT_API_URL"] = address
        try:
            # Two servers at their first start would both lay out the same database.
            with hold_lock(home / "start.lock"):
                server, thread = _start(listener, schedules)
            yield address
        finally:
            del os.environ["PREFECT_API_URL"]
        server.should_exit = True
        thread.join(timeout=5)


def _start(listener: socket.socket, schedules: bool) -> tuple[Any, threading.Thread]:
    import uvicorn
    from prefect.server.api.server import create_app

    app = create_app(ephemeral=not schedules)
    server = uvicorn.Server(uvicorn.Config(app, log_level="error", lifespan="on"))
    thread = threading.Thread(target=server.run, args=([listener],), daemon=True)
    thread.start()
    end = time.monotonic() + _START_SECONDS
    while not server.started:
        if time.monotonic() > end or not thread.is_alive():
            raise BadInput(
                "Prefect's own server did not start",
                f"it must answer within {_START_SECONDS} s and keep its data in data/prefect",
                "see that the disk has room, or run with --no-prefect",
            )
        time.sleep(0.02)
    return server, thread
