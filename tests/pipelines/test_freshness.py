"""The promises of freshness, each as it reads in the README, on a project that a test may break."""

import json
import os
import shutil
import subprocess
import sys

import pytest

from tests.toy import STAGES, Toy


def test_first_run_computes_all_and_second_nothing(toy: Toy) -> None:
    toy.run()
    assert toy.computed() == list(STAGES)
    assert toy.total() == 2 * (1 + 2 + 3 + 4)
    assert "nothing to do" in toy.run()


def test_a_parameter_reruns_its_stage_and_what_depends_on_it(toy: Toy) -> None:
    toy.run()
    toy.run("--set", "factor=3")
    assert toy.computed() == ["double_numbers", "sum_up", "tell_total"]
    assert toy.total() == 30


def test_parameters_a_b_a_is_a_hit_and_brings_back_a_with_its_page(toy: Toy) -> None:
    toy.run()
    page = (toy.root / "reports/one.html").read_text()
    toy.run("--set", "factor=3")
    assert (toy.root / "reports/one.html").read_text() != page
    toy.run()
    assert toy.computed() == []
    assert toy.total() == 20
    assert (toy.root / "reports/one.html").read_text() == page


def test_an_edited_helper_two_imports_away_reruns_what_depends_on_it_and_nothing_else(
    toy: Toy,
) -> None:
    toy.run()
    toy.edit("nodes/toy/deeper.py", "return a * b", "return a * b + 1")
    toy.run()
    assert toy.computed() == ["double_numbers", "sum_up", "tell_total"]
    assert toy.total() == 24


def test_comments_docstrings_and_layout_do_not_count(toy: Toy) -> None:
    toy.run()
    told = "'''Return a product.'''\n    # why\n\n    return (a *\n        b)  # so"
    toy.edit("nodes/toy/deeper.py", "return a * b", told)
    assert "nothing to do" in toy.run()


def test_an_unused_neighbour_does_not_count(toy: Toy) -> None:
    toy.run()
    toy.edit("nodes/toy/helper.py", "return value\n", "return value + 1\n")
    assert "nothing to do" in toy.run()


def test_a_result_that_comes_out_the_same_stops_the_rerun_there(toy: Toy) -> None:
    toy.run()
    toy.edit("nodes/toy/deeper.py", "return a * b", "return b * a")
    toy.run()
    assert toy.computed() == ["double_numbers"]


def test_a_changed_input_file_reruns_what_reads_it(toy: Toy) -> None:
    toy.run()
    toy.write("data/raw/seed/record.json", '{"start": 2}\n')
    toy.run()
    assert toy.computed() == list(STAGES)
    assert toy.total() == 28


def test_an_input_with_the_same_content_elsewhere_is_a_hit(toy: Toy) -> None:
    toy.run()
    shutil.move(toy.root / "data/raw/seed", toy.root / "data/raw/moved")
    toy.edit("catalog/cases/one.yml", "seed/record", "moved/record")
    assert "nothing to do" in toy.run()


def test_a_deleted_artefact_reruns_its_own_stage_only(toy: Toy) -> None:
    toy.run()
    shutil.rmtree(toy.object_file("doubled").parent)
    assert "artefact doubled is gone" in toy.call("status")
    toy.run()
    assert toy.computed() == ["double_numbers"]
    assert toy.object_file("doubled").exists()


def flip_byte(toy: Toy, dataset: str, *, hide: bool) -> None:
    """Flip one bit of an artefact; `hide` puts the time of modification back."""
    path = toy.object_file(dataset)
    before = path.stat()
    path.chmod(0o644)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    path.chmod(0o444)
    if hide:
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


def test_a_flipped_byte_reruns_its_own_stage_only(toy: Toy) -> None:
    toy.run()
    for hide in (False, True):
        flip_byte(toy, "doubled", hide=hide)
        assert "artefact doubled is damaged" in toy.call("status")
        toy.run()
        assert toy.computed() == ["double_numbers"]


def test_a_byte_that_flips_without_a_trace_is_caught_when_it_is_read(toy: Toy) -> None:
    toy.run()
    flip_byte(toy, "doubled", hide=True)
    # As after bit rot: no time of the file tells, so the store's memory says all is well.
    memory = toy.root / "data/store/signatures.json"
    toy.call("status")
    toy.python(f"""
        import json, pathlib
        from catalog.signatures import Signatures
        path = pathlib.Path({str(toy.object_file("doubled").parent)!r})
        memory = pathlib.Path({str(memory)!r})
        signatures = Signatures(memory)
        signatures.hash_path(path)
        from catalog.signatures import _name_of
        name = _name_of(path)
        signatures._known[name] = [path.name, signatures._known[name][1], True]
        signatures._changed = True
        signatures.save()
        """)
    assert "stale" not in toy.call("status")
    assert "damaged" in toy.call("status", "--verify")
    toy.run("--force", "sum_up")
    assert toy.total() == 20
    assert set(toy.computed()) >= {"sum_up"}
    assert json.loads(toy.object_file("doubled").read_text()) == {"values": [2, 4, 6, 8]}


def test_a_damaged_record_reruns_its_stage(toy: Toy) -> None:
    toy.run()
    key = toy.told()["keys"]["sum_up"]
    record = toy.root / "data/store/records" / key[:2] / f"{key}.json"
    text = record.read_text()
    for damaged in (text[:100], text.replace("0", "1", 1), "", "[]"):
        record.chmod(0o644)
        record.write_text(damaged)
        toy.run()
        assert toy.computed() == ["sum_up"]


def test_a_changed_package_version_reruns_what_computes_with_it(toy: Toy, tmp_path) -> None:
    toy.run()
    site = tmp_path / "newer"
    info = site / "numpy-99.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: numpy\nVersion: 99.0\n")
    words = toy.command("run", "--no-prefect", "--case", "one")
    more = {**os.environ, "PYTHONPATH": str(site)}
    status = subprocess.run(
        toy.command("status"), cwd=toy.root, env=more, capture_output=True, text=True, check=True
    )
    assert "package numpy" in status.stdout and "-> 99.0" in status.stdout
    subprocess.run(words, cwd=toy.root, env=more, check=True, capture_output=True)
    assert "sum_up" in toy.computed()
    assert "count_up" not in toy.computed()


def test_a_lost_page_is_put_back_without_computing(toy: Toy) -> None:
    toy.run()
    page = toy.root / "reports/one.html"
    text = page.read_text()
    page.unlink()
    toy.run()
    assert page.read_text() == text
    assert toy.computed() == []


def test_that_a_file_exists_never_means_that_it_is_fresh(toy: Toy) -> None:
    toy.run()
    shutil.rmtree(toy.root / "data/store/records")
    toy.run()
    assert toy.computed() == list(STAGES)


def test_nothing_to_do_loads_neither_prefect_nor_science(toy: Toy) -> None:
    toy.run()
    source = """
        import sys
        sys.argv = ["tendril", "run", "--case", "one"]
        from pipelines.cli import entry
        try:
            entry()
        except SystemExit as end:
            assert not end.code
        heavy = {"prefect", "numpy", "pandas", "scipy", "trimesh", "SimpleITK"}
        print(sorted(heavy & set(sys.modules)))
        """
    assert toy.python(source).splitlines()[-1] == "[]"


def edit_while_it_runs(toy: Toy, stage: str, line: str) -> None:
    """Let a stage append a line to deeper.py, once, when it is called."""
    source = f"f = open('nodes/toy/deeper.py', 'r+'); line = {line!r}\n    "
    source += "line in f.read() or f.write(line); f.close()\n    return {"
    toy.edit(f"nodes/toy/{stage}.py", "return {", source)


def test_an_edit_during_a_run_that_a_stage_does_not_reach_does_no_harm(toy: Toy) -> None:
    edit_while_it_runs(toy, "double_numbers", "x = 1\n")
    toy.run()
    assert toy.computed() == list(STAGES)


@pytest.mark.parametrize("seconds", ["+0", "+0.5"])
def test_an_edit_of_the_same_size_within_a_second_counts(toy: Toy, seconds: str) -> None:
    """Python itself would take the compiled file for fresh: same size, same whole second."""
    path = toy.root / "nodes/toy/deeper.py"
    os.utime(path, (1_000_000_000, 1_000_000_000))
    more = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    words = toy.command("run", "--no-prefect")
    subprocess.run(words, cwd=toy.root, env=more, check=True, capture_output=True)
    toy.edit("nodes/toy/deeper.py", "a * b", "a + b")
    time = 1_000_000_000 + float(seconds)
    os.utime(path, (time, time))
    subprocess.run(words, cwd=toy.root, env=more, check=True, capture_output=True)
    assert toy.computed() == ["double_numbers", "sum_up", "tell_total"]
    assert toy.total() == 18


def test_an_edit_after_code_was_loaded_leaves_the_result_to_the_old_code(toy: Toy) -> None:
    edit_while_it_runs(toy, "sum_up", "def multiply(a, b): return 0\n")
    toy.run()
    assert toy.total() == 20
    toy.run()
    assert toy.computed() == ["double_numbers", "sum_up", "tell_total"]
    assert toy.total() == 0


def test_an_edit_between_plan_and_loading_does_not_count_as_done(toy: Toy) -> None:
    edit_while_it_runs(toy, "count_up", "def multiply(a, b): return 0\n")
    assert "edited while double_numbers" in toy.run(code=3)
    assert toy.told()["stages"] == {"count_up": "computed"}
    toy.run()
    assert toy.total() == 0


def test_two_runs_at_once_share_the_work(toy: Toy) -> None:
    toy.edit(
        "nodes/toy/double_numbers.py", "return {", "import time\n    time.sleep(1.5)\n    return {"
    )
    words = toy.command("run", "--no-prefect", "--case", "one")
    runs = [
        subprocess.Popen(words, cwd=toy.root, stdout=subprocess.PIPE, text=True) for _ in range(2)
    ]
    outputs = [run.communicate()[0] for run in runs]
    assert [run.returncode for run in runs] == [0, 0]
    told = [json.loads(p.read_text()) for p in toy.latest.parent.glob("0*/run.json")]
    statuses = sorted(t["stages"]["double_numbers"] for t in told)
    assert statuses == ["cached", "computed"]
    assert any("another run computes it" in output for output in outputs)
    assert told[0]["outputs"] == told[1]["outputs"]


def test_force_computes_a_fresh_stage_again(toy: Toy) -> None:
    toy.run()
    toy.run("--force", "sum_up")
    assert toy.computed() == ["sum_up"]


def test_only_refuses_inputs_that_are_stale(toy: Toy) -> None:
    answer = toy.run("--only", "sum_up", code=3)
    assert "double_numbers is never run" in answer
    toy.run("--to", "double_numbers")
    assert toy.computed() == ["count_up", "double_numbers"]
    toy.run("--only", "sum_up")
    assert toy.computed() == ["sum_up"]
    toy.run("--from", "sum_up")
    assert toy.computed() == ["tell_total"]


def test_status_says_why(toy: Toy) -> None:
    assert toy.call("status").count("never run") == len(STAGES)
    toy.run()
    assert toy.call("status", "--check").count("fresh") == len(STAGES)
    answer = toy.call("status", "--set", "factor=5", "--check", code=5)
    assert "stale      double_numbers  parameter factor: 2.0 -> 5.0" in answer
    assert "stale      sum_up  double_numbers runs before it" in answer
    toy.edit("nodes/toy/deeper.py", "a * b", "a * b * 1")
    assert "code toy.deeper.multiply was edited" in toy.call("status")


def test_python_runs_loads_and_calls_by_hand(toy: Toy) -> None:
    printed = toy.python("""
        from pipelines import open_case
        case = open_case("one", "factor=4")
        print(case.run().computed, case.run().computed)
        print(case.load("total")["total"], case.load("seed_file"))
        print(case.node("sum_up")({"values": [1, 2]})["total"])
        print(case.parameters("double_numbers").factor, [p.state for p in case.status()])
        """)
    assert printed.split("\n")[:4] == [
        "4 0",
        "40.0 {'start': 1}",
        "3.0",
        "4.0 ['fresh', 'fresh', 'fresh', 'fresh']",
    ]


@pytest.mark.parametrize(
    "before",
    [
        "from pipelines import open_case; open_case('one').run()",
        "from nodes.toy.double_numbers import double_numbers",
    ],
)
def test_a_python_that_loaded_older_source_stores_nothing_for_the_newer(
    toy: Toy, before: str
) -> None:
    printed = toy.python(f"""
        {before}
        import pathlib
        path = pathlib.Path("nodes/toy/deeper.py")
        path.write_text(path.read_text().replace("a * b", "a * b + 7"))
        from pipelines import open_case
        try:
            open_case("one").run()
        except Exception as error:
            print(type(error).__name__, "restart" in str(error))
        """)
    assert printed.strip() == "BadInput True"
    toy.run()
    assert toy.total() == 48


def test_a_failure_is_noted_and_the_next_run_goes_on_from_there(toy: Toy) -> None:
    toy.edit("nodes/toy/sum_up.py", '"big"', '"bad": 1 / 0, "big"')
    assert "ZeroDivisionError" in toy.run(code=1)
    assert toy.told()["status"] == "failed"
    assert toy.told()["stages"] == {"count_up": "computed", "double_numbers": "computed"}
    toy.edit("nodes/toy/sum_up.py", '"bad": 1 / 0, "big"', '"big"')
    toy.run()
    assert toy.computed() == ["sum_up", "tell_total"]
    assert sys.version_info >= (3, 11)


def test_a_run_killed_at_any_line_then_rerun_ends_as_if_never_killed(toy: Toy) -> None:
    printed = toy.python("""
        import json, os, pathlib, shutil, signal, sys
        import catalog.locks, catalog.signatures, catalog.store
        import pipelines.engine, pipelines.history, pipelines.index, pipelines.running
        from pipelines import open_case

        open_case("one").run()  # loads all modules; every child is a fork of this process
        wanted = pathlib.Path("data/runs/one/latest/run.json").read_text()
        page = pathlib.Path("reports/one.html").read_text()
        watched = {
            m.__file__ for m in (
                catalog.locks, catalog.signatures, catalog.store, pipelines.engine,
                pipelines.history, pipelines.index, pipelines.running,
            )
        }

        def in_child(act):
            child = os.fork()
            if child == 0:
                code = 99
                try:
                    act()
                    code = 0
                finally:
                    os._exit(code)
            return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

        def killed(number):
            left = [number]
            def trace(frame, event, argument):
                if frame.f_code.co_filename not in watched:
                    return None
                if event == "line":
                    left[0] -= 1
                    if left[0] == 0:
                        os.kill(os.getpid(), signal.SIGKILL)
                return trace
            sys.settrace(trace)
            open_case("one").run()

        number, kills = 1, 0
        while True:
            shutil.rmtree("data/store"), shutil.rmtree("data/runs"), shutil.rmtree("reports")
            code = in_child(lambda: killed(number))
            assert in_child(lambda: open_case("one").run()) == 0
            told = json.loads(pathlib.Path("data/runs/one/latest/run.json").read_text())
            assert told["status"] == "complete"
            assert told["outputs"].keys() == json.loads(wanted)["outputs"].keys()
            assert told["outputs"]["total"] == json.loads(wanted)["outputs"]["total"]
            assert "20.0" in pathlib.Path("reports/one.html").read_text()
            assert pathlib.Path("reports/index.html").exists()
            assert list(pathlib.Path("data/store/scratch").iterdir()) == []
            if code == 0:
                break
            assert code == -signal.SIGKILL
            kills += 1
            number += 41  # every line would take minutes
        print(kills)
        """)
    assert int(printed) > 10


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("nodes/toy/sum_up.py", "Add numbers.", "Add all numbers."),
        ("pipelines/account.py", "title=job.case.title", "title=job.case.title.upper()"),
        ("catalog/cases/one.yml", "Case one", "Case uno"),
        ("pipelines/toy.py", '["total"])', '["total"], name="add")'),
    ],
)
def test_a_page_is_made_anew_when_what_it_tells_has_changed(
    toy: Toy, file: str, old: str, new: str
) -> None:
    toy.run()
    toy.edit(file, old, new)
    toy.run()
    assert toy.computed() == ["tell_total"]


def test_a_page_that_gets_another_place_is_published_there(toy: Toy) -> None:
    toy.run()
    toy.edit("catalog/catalog.yml", "reports/{case}.html", "reports/pages/{case}.html")
    toy.run()
    assert toy.computed() == []
    assert (toy.root / "reports/pages/one.html").exists()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('["doubled"], ["total"]', '["total"], ["doubled"]', "pipeline toy"),
        ('["total"])', '["total"], name="count_up")', "count_up"),
        ('["doubled"], ["total"]', '["doubled"], ["numbers"]', "numbers"),
        ("toy.sum_up", "toy.sum_it_up", "no function sum_it_up"),
        ('["seed_file"], ["numbers"]', '["seed"], ["numbers"]', "takes seed_file"),
    ],
)
def test_a_pipeline_that_does_not_fit_is_refused(toy: Toy, old: str, new: str, told: str) -> None:
    toy.edit("pipelines/toy.py", old, new)
    assert told in toy.run(code=3)


def test_source_that_is_no_python_is_told_with_its_line(toy: Toy) -> None:
    toy.edit("nodes/toy/deeper.py", "return a * b", "return a *")
    assert "deeper.py, line 2" in toy.run(code=3)


@pytest.mark.parametrize("text", ['{"status": "complete"}', "[]", "{", '{"keys": 3}', ""])
def test_a_spoilt_note_of_a_run_is_passed_over(toy: Toy, text: str) -> None:
    toy.run()
    (toy.latest / "run.json").write_text(text)
    toy.run()
    assert toy.told()["status"] == "complete"
    assert toy.computed() == []
    toy.call("status", "--check")
    toy.call("clean")


def test_the_page_of_all_cases_is_as_fresh_as_the_cases(toy: Toy) -> None:
    toy.run()
    index = toy.root / "reports/index.html"
    text = index.read_text()
    index.write_text(text.replace("Case one", "Case ane"))
    toy.run()
    assert index.read_text() == text
    (toy.root / "catalog/cases/two.yml").write_text(
        (toy.root / "catalog/cases/one.yml").read_text()
    )
    toy.run()
    assert "two" in index.read_text()
    (toy.root / "catalog/cases/two.yml").unlink()
    toy.run()
    assert index.read_text() == text


def test_an_input_that_cannot_be_read_is_told_without_its_name(toy: Toy) -> None:
    printed = toy.python("""
        import catalog.signatures
        from pipelines import open_case

        def refuse(file):
            raise PermissionError(13, "Permission denied", "Doe_Jane.json")

        catalog.signatures._hash_file = refuse
        try:
            open_case("one").run()
        except Exception as error:
            print(error, error.exit_code)
        """)
    assert "input seed_file cannot be read: Permission denied" in printed
    assert "Doe" not in printed
    assert printed.strip().endswith("3")


def test_a_page_that_cannot_be_written_is_told_as_a_matter_of_the_disk(toy: Toy) -> None:
    (toy.root / "reports").write_text("in the way")
    answer = toy.run(code=4)
    assert "could not write one.html" in answer
    (toy.root / "reports").unlink()
    toy.run()
    assert (toy.root / "reports/one.html").exists()
