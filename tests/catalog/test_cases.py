"""Cases say what they mean or are refused; their paths stay where they may be."""

from pathlib import Path

import pytest

from catalog.cases import Case, check_case_name, list_cases, load_case, resolve_input
from nodes.errors import BadInput
from tests.conftest import ROOT

GOOD = "title: A case\npipeline: anatomy\n"


def load(folder: Path, text: str) -> Case:
    (folder / "one.yml").write_text(text)
    return load_case(folder, "one")


def refused(folder: Path, text: str) -> str:
    with pytest.raises(BadInput) as caught:
        load(folder, text)
    return str(caught.value)


@pytest.mark.parametrize("name", list_cases(ROOT / "catalog/cases"))
def test_every_real_case_loads(name: str) -> None:
    check_case_name(name)
    case = load_case(ROOT / "catalog/cases", name)
    assert (case.name, bool(case.title)) == (name, True)


def test_a_case_is_what_its_file_says(tmp_path: Path) -> None:
    case = load(tmp_path, GOOD + "inputs: {ct_files: a/b}\nparameters: {segment_ct: {x: 1}}\n")
    assert (case.name, case.title, case.pipeline) == ("one", "A case", "anatomy")
    assert case.inputs == {"ct_files": "a/b"}
    assert case.parameters == {"segment_ct": {"x": 1}}


def test_empty_parts_are_as_none(tmp_path: Path) -> None:
    assert load(tmp_path, GOOD + "inputs:\nparameters:\n") == load(tmp_path, GOOD)


def test_an_unknown_case_is_answered_with_the_nearest(tmp_path: Path) -> None:
    load(tmp_path, GOOD)
    for name in ("onee", "../one", "", "one.yml"):
        with pytest.raises(BadInput, match=r"did you mean one\?|known: one"):
            load_case(tmp_path, name)
    with pytest.raises(BadInput, match="known: none"):
        load_case(tmp_path / "none", "one")


def test_an_unknown_key_is_answered_with_the_nearest(tmp_path: Path) -> None:
    text = refused(tmp_path, GOOD + "parameter: {}\n")
    assert "one.yml: unknown key parameter" in text and "did you mean parameters?" in text


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "title is missing"),
        ("title: x\n", "pipeline is missing"),
        (GOOD + "name: two\n", "a case is named by its file"),
        (GOOD + "inputs: some/path\n", "inputs = 'some/path'"),
        (GOOD + "inputs: {ct_files: 3}\n", "inputs.ct_files = 3"),
        (GOOD + "inputs: {ct_files: [a, b]}\n", "inputs.ct_files"),
        (GOOD + "parameters: {segment_ct: 3}\n", "parameters.segment_ct = 3"),
        (GOOD + "parameters: [a]\n", "parameters = ['a']"),
        ("title: 3\npipeline: anatomy\n", "title = 3"),
    ],
)
def test_a_broken_case_is_told_with_file_and_key(tmp_path: Path, text: str, told: str) -> None:
    answer = refused(tmp_path, text)
    assert answer.startswith("one.yml") and told in answer


@pytest.mark.parametrize("name", ["a", "phantom_2", "0", "a-b", "x" * 64])
def test_a_plain_name_is_allowed(name: str) -> None:
    check_case_name(name)


@pytest.mark.parametrize(
    "name", ["", "A", "-a", "_a", "a b", "a/b", "..", "a.b", "é", "x" * 65, "a\n", "a\0"]
)
def test_a_name_that_is_no_file_name_everywhere_is_refused(name: str) -> None:
    with pytest.raises(BadInput, match="letters a-z"):
        check_case_name(name)


RAW = Path("/raw")


def test_an_input_lies_below_raw_or_is_absolute_or_starts_with_a_variable(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    variables = {"DATA": Path("/default")}
    assert resolve_input("a/b", RAW, {}) == Path("/raw/a/b")
    assert resolve_input("/a/b", RAW, {}) == Path("/a/b")
    assert resolve_input("${DATA}/b", RAW, variables) == Path("/default/b")
    monkeypatch.setenv("DATA", "")
    assert resolve_input("${DATA}/b", RAW, variables) == Path("/default/b")
    monkeypatch.setenv("DATA", "/set \\1")
    assert resolve_input("${DATA}/b", RAW, variables) == Path("/set \\1/b")


def test_a_relative_variable_is_meant_from_where_the_program_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("DATA", "here/../there")
    assert resolve_input("${DATA}/b", RAW, {}) == tmp_path / "there/b"


def test_a_variable_that_is_not_set_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DATA", raising=False)
    with pytest.raises(BadInput, match="export DATA="):
        resolve_input("${DATA}/b", RAW, {})


@pytest.mark.parametrize("path", ["../x", "a/../../x", "/a/../b", "${DATA}/../x", "..", "a/.."])
def test_a_path_must_not_climb(path: str) -> None:
    with pytest.raises(BadInput, match="must not climb"):
        resolve_input(path, RAW, {"DATA": Path("/data")})


def test_dots_in_names_are_no_climbing() -> None:
    assert resolve_input("a..b/...", RAW, {}) == Path("/raw/a..b/...")
