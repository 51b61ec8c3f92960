"""The command line as a person and a script meet it."""

import json
import os
import pty
import signal
import subprocess
import sys
import time

import pytest

from tests.toy import STAGES, Toy


def test_help_of_every_command_has_a_summary_and_the_group_names_exit_codes(toy: Toy) -> None:
    answer = toy.call("--help")
    for command in ("run", "status", "list", "new-case", "report", "serve", "clean", "completion"):
        assert f"  {command} " in answer
        assert "Usage:" in toy.call(command, "--help")
    assert "130  stopped with Ctrl-C" in answer
    assert "not a medical device" in answer


@pytest.mark.parametrize(
    ("words", "code", "proposal"),
    [
        (["statsu"], 2, "status"),
        (["run", "--forse", "sum_up"], 2, "--force"),
        (["run", "toi"], 3, "did you mean toy?"),
        (["run", "--case", "onee"], 3, "did you mean one?"),
        (["run", "--only", "sumup"], 3, "did you mean sum_up?"),
        (["run", "--set", "facktor=3"], 3, "did you mean factor?"),
        (["run", "--set", "double_numbers.facto=3"], 3, "did you mean double_numbers.factor?"),
        (["run", "--set", "factor"], 3, "key=value"),
        (["run", "--set", "factor=many"], 3, "What each number is multiplied by"),
        (["run", "--only", "sum_up", "--to", "sum_up"], 3, "stands alone"),
        (["run", "--only", "sum_up", "--force", "count_up"], 3, "--from count_up"),
        (["clean", "--keep", "0"], 2, "--keep"),
        (["report", "onee"], 3, "did you mean one?"),
        (["report", "one"], 3, "tendril run --case one"),
    ],
)
def test_a_typo_is_answered_with_the_nearest_name(
    toy: Toy, words: list[str], code: int, proposal: str
) -> None:
    assert proposal in toy.call(*words, code=code)
    assert not (toy.root / "data/store/records").exists()


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("parameters: {double_numbers: {facto: 3}}", "did you mean factor?"),
        ("parameters: {double_number: {factor: 3}}", "did you mean double_numbers?"),
        ("parameters: {sum_up: {x: 3}}", "sum_up.x"),
        ("parametres: {}", "did you mean parameters?"),
        ("pipelin: toy", "did you mean pipeline?"),
        ("inputs: {seed_files: x.json}", "did you mean seed_file?"),
        ("inputs: {seed_file: ../../secret.json}", "must not climb"),
        ("inputs: {seed_file: nowhere.json}", "nothing at"),
        ("title: [", "line"),
        ("pipeline: toy", "stands twice"),
    ],
)
def test_a_case_that_breaks_a_rule_is_refused(toy: Toy, line: str, told: str) -> None:
    lines = {"title": "title: One", "pipeline": "pipeline: toy"}
    lines["inputs"] = "inputs: {seed_file: seed/record.json}"
    if not told.startswith("stands"):
        lines.pop(line.partition(":")[0], None)
    toy.write("catalog/cases/one.yml", "\n".join([*lines.values(), line]) + "\n")
    answer = toy.run(code=3)
    assert told in answer
    assert "rule: " in answer and "cure: " in answer


def test_a_run_prints_plain_lines_where_there_is_no_terminal(toy: Toy) -> None:
    lines = toy.run().splitlines()
    assert lines[0] == "one: Case one"
    assert [line.split()[1] for line in lines[1:5]] == list(STAGES)
    assert "\x1b" not in "".join(lines)
    assert lines[-2:] == ["  page  reports/one.html", "  data  data/runs/one/latest"]


def test_a_terminal_shows_a_bar_with_the_stage_and_the_time_left(toy: Toy) -> None:
    toy.edit("nodes/toy/sum_up.py", "return {", "import time\n    time.sleep(1.5)\n    return {")
    toy.run()
    leader, follower = pty.openpty()
    process = subprocess.Popen(
        toy.command("run", "--no-prefect", "--force", "sum_up"),
        cwd=toy.root, stdout=follower, stderr=follower,
    )  # fmt: skip
    os.close(follower)
    shown = b""
    while True:
        try:
            shown += os.read(leader, 65536)
        except OSError:  # the terminal closes when the program ends
            break
    assert process.wait() == 0
    text = shown.decode()
    assert "one: sum_up" in text
    assert "2/4 stages" in text
    assert "about 1 s left" in text or "about 2 s left" in text


def test_ctrl_c_stops_cleanly_and_keeps_what_is_finished(toy: Toy) -> None:
    toy.edit("nodes/toy/sum_up.py", "return {", "import time\n    time.sleep(60)\n    return {")
    for number in (signal.SIGINT, signal.SIGTERM):
        process = subprocess.Popen(
            toy.command("run", "--no-prefect"),
            cwd=toy.root, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert process.stdout is not None
        while "double_numbers" not in (line := process.stdout.readline()):
            assert line
        time.sleep(0.3)
        process.send_signal(number)
        _, errors = process.communicate(timeout=10)
        assert process.returncode == 130
        assert errors.strip().endswith("the next run goes on from there")
        assert "Traceback" not in errors
        assert toy.told()["status"] == "interrupted"
    assert list((toy.root / "data/store/scratch").iterdir()) == []


def test_list_names_all_there_is(toy: Toy) -> None:
    everything = toy.call("list")
    for name in (*STAGES, "toy", "seed_file", "one", "record"):
        assert name in everything
    assert toy.call("list", "cases").splitlines()[1].split()[:2] == ["one", "toy"]


def test_new_case_writes_a_file_that_runs(toy: Toy, tmp_path) -> None:
    (tmp_path / "record.json").write_text('{"start": 5}')
    answer = toy.call("new-case", "two", "--seed", str(tmp_path / "record.json"))
    assert "tendril run --case two" in answer
    text = (toy.root / "catalog/cases/two.yml").read_text()
    assert "#    factor: 2.0" in text
    toy.call("run", "--no-prefect", "--case", "two")
    told = json.loads((toy.root / "data/runs/two/latest/run.json").read_text())
    assert told["status"] == "complete"
    assert 'href="two.html"' in (toy.root / "reports/index.html").read_text()
    # What is taken out of its comment takes effect.
    lines = [
        line.replace("#  ", "  ").replace("#    ", "    ").replace("factor: 2.0", "factor: 7.0")
        if "double_numbers" in line or "factor: " in line
        else line
        for line in text.splitlines()
    ]
    toy.write("catalog/cases/two.yml", "\n".join(lines))
    assert "parameter factor: 2.0 -> 7.0" in toy.call("status", "--case", "two")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["one", "--seed", "data/raw/seed"], "never overwritten"),
        (["Two words", "--seed", "data/raw/seed"], "letters a-z"),
        (["../up", "--seed", "data/raw/seed"], "letters a-z"),
        (["three", "--seed", "nowhere"], "must exist"),
        (["three"], "give one of --seed"),
        (["index", "--seed", "data/raw/seed"], "not `index`"),
        (["three", "--pipeline", "toy"], "takes seed_file"),
    ],
)
def test_new_case_refuses(toy: Toy, words: list[str], told: str) -> None:
    assert told in toy.call("new-case", *words, code=3)
    assert [p.name for p in (toy.root / "catalog/cases").iterdir()] == ["one.yml"]


def test_report_prints_the_pages(toy: Toy) -> None:
    toy.run()
    assert toy.call("report", "one").strip() == "reports/one.html"
    assert toy.call("report").strip() == "reports/index.html"


def test_clean_drops_what_no_kept_run_uses(toy: Toy) -> None:
    toy.run()
    toy.run("--set", "factor=3")
    assert "would drop 1 runs" in toy.call("clean", "--dry-run")
    toy.call("clean")
    assert "nothing to do" in toy.run("--set", "factor=3")
    toy.run()
    assert toy.computed() == ["double_numbers", "sum_up", "tell_total"]
    toy.call("clean", "--keep", "2")
    toy.run("--set", "factor=3")
    assert toy.computed() == []


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_is_a_script_for_the_shell(toy: Toy, shell: str) -> None:
    assert "_TENDRIL_COMPLETE" in toy.call("completion", shell)


def test_completion_knows_cases_and_stages(toy: Toy) -> None:
    for words, name in (("tendril run --case o", "one"), ("tendril run --only sum", "sum_up")):
        environment = {
            **os.environ,
            "_TENDRIL_COMPLETE": "bash_complete",
            "COMP_WORDS": words,
            "COMP_CWORD": str(len(words.split()) - 1),
        }
        source = "from pipelines.cli import main; main(prog_name='tendril')"
        done = subprocess.run(
            [sys.executable, "-c", source],
            cwd=toy.root,
            env=environment,
            capture_output=True,
            text=True,
        )
        assert done.stdout.strip() == f"plain,{name}"


def test_a_full_disk_is_told_and_the_next_run_completes(toy: Toy) -> None:
    limit = "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
    limit += "resource.setrlimit(resource.RLIMIT_FSIZE, (12000, 12000));"
    source = limit + "import sys; sys.argv = ['tendril', 'run', '--no-prefect'];"
    source += "from pipelines.cli import entry; entry()"
    toy.python(source, code=4)  # `total` is 20 kB, the others are small
    assert not list((toy.root / "data/store/scratch").iterdir())
    toy.run()
    assert toy.computed() == ["sum_up", "tell_total"]


def test_a_case_whose_input_is_elsewhere_is_skipped_unless_named(toy: Toy) -> None:
    toy.write(
        "catalog/cases/away.yml",
        "title: Away\npipeline: toy\ninputs: {seed_file: nowhere/record.json}\n",
    )
    assert "away: skipped" in toy.call("run", "--no-prefect")
    assert "nothing at" in toy.call("run", "--no-prefect", "--case", "away", code=3)


def test_a_long_case_runs_where_its_pipeline_or_that_whose_variant_it_is_is_named(toy: Toy) -> None:
    toy.write("pipelines/toy_long.py", "from pipelines.toy import STAGES\n")
    toy.edit("pipelines/registry.py", "import toy", "import toy, toy_long")
    toy.edit("pipelines/registry.py", '"toy": toy', '"toy": toy, "toy_long": toy_long')
    toy.write(
        "catalog/cases/long.yml",
        "title: L\npipeline: toy_long\non_request: true\ninputs: {seed_file: seed/record.json}\n",
    )
    assert "long: skipped, it runs on request" in toy.call("run", "--no-prefect")
    assert "long: done" in toy.call("run", "toy", "--no-prefect")
    assert "one: " not in toy.call("run", "toy_long", "--no-prefect")


def test_one_case_that_fails_does_not_stop_the_others(toy: Toy) -> None:
    toy.write("catalog/cases/a_broken.yml", "title: [\n")
    toy.write("catalog/cases/b_refused.yml", "title: B\npipeline: nothing\n")
    answer = toy.call("run", "--no-prefect", code=3)
    assert "a_broken.yml, line" in answer
    assert "known: toy" in answer
    assert "one: done, 4 computed" in answer
    assert toy.call("status", code=3).count("fresh") == len(STAGES)
    assert "refused" in toy.call("list", "cases")
