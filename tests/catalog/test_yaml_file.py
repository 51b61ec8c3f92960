"""YAML as people write it: what is not what it seems is refused with file and line."""

from pathlib import Path

import pytest

from catalog.yaml_file import load_mapping, load_value, value_text
from nodes.errors import BadInput


def refused(tmp_path: Path, content: bytes) -> str:
    path = tmp_path / "toy.yml"
    path.write_bytes(content)
    with pytest.raises(BadInput) as caught:
        load_mapping(path)
    return str(caught.value)


def test_a_mapping_is_returned(tmp_path: Path) -> None:
    path = tmp_path / "toy.yml"
    path.write_text("a: 1.5\nb: {c: [1, x]}\nd: é\n", "utf-8")
    assert load_mapping(path) == {"a": 1.5, "b": {"c": [1, "x"]}, "d": "é"}


@pytest.mark.parametrize("content", ["", "# only a comment\n", "---\n", "\ufeff"])
def test_an_empty_file_is_an_empty_mapping(tmp_path: Path, content: str) -> None:
    path = tmp_path / "toy.yml"
    path.write_text(content, "utf-8")
    assert load_mapping(path) == {}


@pytest.mark.parametrize(
    "content",
    [b"a: 1\nb: 2\na: 3\n", b"x: 1\ny:\n  z: 1\n  z: 2\n"],
    ids=["at the top", "further in"],
)
def test_a_key_that_stands_twice_is_refused_with_its_line(tmp_path: Path, content: bytes) -> None:
    text = refused(tmp_path, content)
    assert "stands twice" in text
    assert f"toy.yml, line {content.count(10)}" in text


def test_a_tab_is_refused_with_its_line(tmp_path: Path) -> None:
    assert "toy.yml, line 2" in refused(tmp_path, b"a:\n\tb: 1\n")


@pytest.mark.parametrize(
    "content",
    [bytes(range(256)), b"\x89PNG\r\n\x1a\n\0\0", "a: é".encode("latin-1"), b"a: \0", b"a: [1"],
)
def test_what_is_no_yaml_is_refused(tmp_path: Path, content: bytes) -> None:
    assert "the file must be YAML" in refused(tmp_path, content)


@pytest.mark.parametrize("content", [b"- 1\n- 2\n", b"just text", b"3\n", b"false\n"])
def test_what_is_no_mapping_is_refused(tmp_path: Path, content: bytes) -> None:
    assert "key: value" in refused(tmp_path, content)


@pytest.mark.parametrize("content", [b"a: 1\n---\nb: 2\n", b"? [1, 2]\n: 3\n", b"? {a: 1}\n: 3\n"])
def test_what_would_be_half_read_is_refused(tmp_path: Path, content: bytes) -> None:
    refused(tmp_path, content)


@pytest.mark.parametrize(
    "tag", ["!!python/object/apply:os.getcwd []", "!x 1", "!!python/name:os.x"]
)
def test_yaml_runs_no_code(tmp_path: Path, tag: str) -> None:
    refused(tmp_path, f"a: {tag}\n".encode())


def test_a_missing_file_and_a_folder_are_told(tmp_path: Path) -> None:
    for path in (tmp_path / "none.yml", tmp_path):
        with pytest.raises(BadInput, match="must be there and readable"):
            load_mapping(path)


@pytest.mark.parametrize(
    ("text", "value"),
    [("3", 3), ("-1.5", -1.5), ("[1, 2]", [1, 2]), ("true", True), ("soft tissue", "soft tissue"),
     ("a: b: c", "a: b: c"), ("{", "{"), ("{a: 1, a: 2}", "{a: 1, a: 2}"), ("%", "%")],
)  # fmt: skip
def test_a_value_means_what_yaml_says_or_itself(text: str, value: object) -> None:
    assert load_value(text) == value


@pytest.mark.parametrize(
    "value", [1, 1.5, "a b", "", "no", None, True, [1.5, 2], {"a": [1, "x"]}, "é", "1", "x" * 200]
)
def test_a_value_written_on_one_line_is_read_as_the_same(value) -> None:
    assert "\n" not in value_text(value)
    assert load_value(value_text(value)) == value
