"""Prefect around the engine: what its own records say, and that nothing of it stays behind."""

import os
import signal
import socket
import sqlite3
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.toy import STAGES, Toy


def database_rows(toy: Toy, query: str) -> list[tuple]:
    with sqlite3.connect(toy.root / "data/prefect/prefect.db") as database:
        return database.execute(query).fetchall()


def servers_of(toy: Toy) -> list[str]:
    """Return command lines of processes that work in the toy's folder."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if (process / "cwd").resolve() == toy.root:
                found.append((process / "cmdline").read_bytes().decode().replace("\0", " "))
        except OSError:
            continue
    return found


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Toy:
    """A project that Prefect ran twice: all computed, then one stage forced and the rest cached."""
    toy = Toy(tmp_path_factory.mktemp("flown") / "toy")
    toy.call("run", "--case", "one")
    toy.call("run", "--case", "one", "--force", "sum_up")
    return toy


def test_each_stage_is_one_task_and_fresh_ones_appear_as_cached(flown: Toy) -> None:
    query = "select state_name, count(*) from task_run group by state_name order by state_name"
    assert database_rows(flown, query) == [("Cached", 3), ("Completed", 5)]
    names = database_rows(flown, "select distinct name from task_run")
    assert {name.rpartition("-")[0] for (name,) in names} == set(STAGES)


def test_each_run_links_its_page_as_an_artifact(flown: Toy) -> None:
    rows = database_rows(flown, "select key, type, data from artifact")
    assert [(key, kind) for key, kind, _ in rows] == [("page-one", "markdown")] * 2
    assert (flown.root / "reports/one.html").as_uri() in rows[0][2]


def test_a_flow_is_named_after_pipeline_and_case(flown: Toy) -> None:
    rows = database_rows(
        flown,
        "select flow.name, flow_run.name, state_name from flow_run join flow on flow.id = flow_id",
    )
    assert rows == [("toy", "one", "Completed")] * 2


def test_no_server_is_left_by_a_kill(toy: Toy) -> None:
    toy.edit("nodes/toy/sum_up.py", "return {", "import time\n    time.sleep(60)\n    return {")
    run = subprocess.Popen(
        toy.command("run", "--case", "one"), cwd=toy.root, stdout=subprocess.PIPE, text=True
    )
    assert run.stdout is not None
    while "double_numbers" not in (line := run.stdout.readline()):
        assert line, "ended before the stage was reached"
    run.kill()
    run.wait()
    time.sleep(0.5)
    assert servers_of(toy) == []
    toy.edit("nodes/toy/sum_up.py", "time.sleep(60)", "time.sleep(0)")
    toy.call("run", "--case", "one")
    assert toy.computed() == ["sum_up", "tell_total"]


def test_ctrl_c_stops_cleanly_and_the_next_run_goes_on_from_there(toy: Toy) -> None:
    toy.edit("nodes/toy/sum_up.py", "return {", "import time\n    time.sleep(60)\n    return {")
    run = subprocess.Popen(
        toy.command("run", "--case", "one"),
        cwd=toy.root, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert run.stdout is not None
    while "double_numbers" not in (line := run.stdout.readline()):
        assert line, "ended before the stage was reached"
    time.sleep(0.5)
    run.send_signal(signal.SIGINT)
    _, errors = run.communicate(timeout=20)
    assert run.returncode == 130, errors
    assert "goes on from there" in errors
    assert "Traceback" not in errors
    assert toy.told()["status"] == "interrupted"
    assert servers_of(toy) == []
    toy.edit("nodes/toy/sum_up.py", "time.sleep(60)", "time.sleep(0)")
    toy.call("run", "--case", "one")
    assert toy.computed() == ["sum_up", "tell_total"]


def test_a_failure_is_told_as_it_is_but_its_words_stay_out_of_the_database(toy: Toy) -> None:
    toy.edit("nodes/toy/sum_up.py", "return {", "raise KeyError('Doe^Jane 1970')\n    return {")
    answer = toy.call("run", "--case", "one", code=1)
    assert "Doe^Jane" in answer
    database = (toy.root / "data/prefect").rglob("*")
    assert not any(b"Doe^Jane" in path.read_bytes() for path in database if path.is_file())
    rows = database_rows(toy, "select state_name from flow_run")
    assert rows == [("Failed",)]


def test_two_first_runs_at_once_with_prefect_harm_nothing(toy: Toy) -> None:
    words = toy.command("run", "--case", "one")
    runs = [
        subprocess.Popen(words, cwd=toy.root, stderr=subprocess.PIPE, text=True) for _ in range(2)
    ]
    errors = [run.communicate(timeout=120)[1] for run in runs]
    assert [run.returncode for run in runs] == [0, 0], errors
    assert toy.total() == 20


def wait_until(condition: Callable[[], bool], seconds: float) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.2)


def wait_for_server(address: str, seconds: float) -> None:
    host, port = address.split("//")[1].split("/")[0].split(":")
    end = time.monotonic() + seconds
    while True:
        try:
            socket.create_connection((host, int(port)), timeout=1).close()
            return
        except OSError:
            assert time.monotonic() < end, "the server did not answer"
            time.sleep(0.1)


def test_a_server_in_prefect_api_url_is_used(toy: Toy) -> None:
    source = """
        import os, sys, time
        from pathlib import Path
        from pipelines.server import prefect_server
        with prefect_server(Path("other")) as address:
            print(address, flush=True)
            time.sleep(60)
        """
    server = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(source)],
        cwd=toy.root, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert server.stdout is not None
        address = server.stdout.readline().strip()
        wait_for_server(address, 60)
        done = subprocess.run(
            toy.command("run", "--case", "one"),
            cwd=toy.root, env={**os.environ, "PREFECT_API_URL": address}, capture_output=True,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
    finally:
        server.kill()
        server.wait()
    assert not (toy.root / "data/prefect/prefect.db").exists()
    with sqlite3.connect(toy.root / "other/prefect/prefect.db") as database:
        assert database.execute("select name from flow_run").fetchall() == [("one",)]


def test_a_damaged_database_of_prefect_is_put_aside(toy: Toy) -> None:
    (toy.root / "data/prefect").mkdir(parents=True)
    (toy.root / "data/prefect/prefect.db").write_bytes(b"no database" * 500)
    toy.call("run", "--case", "one")
    assert toy.total() == 20
    assert (toy.root / "data/prefect/damaged.db").exists()
    assert database_rows(toy, "select state_name from flow_run") == [("Completed",)]


def test_a_server_in_prefect_api_url_that_does_not_answer_is_refused(toy: Toy) -> None:
    done = subprocess.run(
        toy.command("run", "--case", "one"),
        cwd=toy.root, env={**os.environ, "PREFECT_API_URL": "http://127.0.0.1:9/api"},
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 3
    assert "unset PREFECT_API_URL" in done.stderr
    assert "Traceback" not in done.stderr


def test_ctrl_c_while_the_server_starts_stops_cleanly(toy: Toy) -> None:
    for delay in (1.0, 2.0, 3.0):
        run = subprocess.Popen(
            toy.command("run", "--case", "one"), cwd=toy.root,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        time.sleep(delay)
        run.send_signal(signal.SIGINT)
        _, errors = run.communicate(timeout=60)
        assert run.returncode == 130, errors
        assert "Traceback" not in errors
        assert servers_of(toy) == []
    toy.call("run", "--case", "one")
    assert toy.total() == 20


def test_a_killed_server_takes_its_scheduled_runs_along(toy: Toy) -> None:
    toy.edit("nodes/toy/sum_up.py", "return {", "import time\n    time.sleep(99)\n    return {")
    toy.write(
        "prefect.yaml",
        "deployments: [{name: soon, entrypoint: 'pipelines/flows.py:run_cases',"
        " schedules: [{interval: 5}]}]\n",
    )
    serving = subprocess.Popen(toy.command("serve"), cwd=toy.root, stdout=subprocess.DEVNULL)
    records = toy.root / "data/store/records"
    wait_until(lambda: len(list(records.glob("*/*.json"))) == 2, 90)  # it is at the third stage
    assert len(servers_of(toy)) >= 2
    serving.kill()
    serving.wait()
    wait_until(lambda: servers_of(toy) == [], 40)


def test_an_interval_schedule_makes_a_run_that_completes_on_a_real_server(toy: Toy) -> None:
    toy.write(
        "prefect.yaml",
        textwrap.dedent("""
            deployments:
              - name: soon
                entrypoint: pipelines/flows.py:run_cases
                schedules: [{interval: 5}]
                parameters: {cases: [one]}
            """),
    )
    serving = subprocess.Popen(
        toy.command("serve"), cwd=toy.root, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    try:
        end = time.monotonic() + 90
        rows: list[tuple] = []
        while not rows and time.monotonic() < end:
            time.sleep(1)
            assert serving.poll() is None
            if (toy.root / "data/prefect/prefect.db").exists():
                query = """select state_name from flow_run join flow on flow.id = flow_id
                           where flow.name = 'tendril' and state_name = 'Completed'
                           and auto_scheduled"""
                try:
                    rows = database_rows(toy, query)
                except sqlite3.OperationalError:  # its tables are not laid out yet
                    continue
        assert rows
        assert toy.total() == 20
    finally:
        serving.send_signal(signal.SIGINT)
        try:
            code = serving.wait(timeout=30)
        except subprocess.TimeoutExpired:
            serving.kill()
            raise
    assert code == 0
    time.sleep(1)
    assert servers_of(toy) == []
