"""What is remembered comes back or is gone, and never stops a run."""

from pathlib import Path

import pytest

from catalog.memory import recall, remember


def test_what_is_remembered_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "new" / "memory.json"
    remember(path, {"a": [1, "é\udcff"]})
    assert recall(path) == {"a": [1, "é\udcff"]}
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("content", [b"", b"[1]", b"\xff\xfe", b'{"a":', b"[" * 100_000, b"3"])
def test_a_damaged_file_is_as_none(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "memory.json"
    path.write_bytes(content)
    assert recall(path) == {}
    assert recall(tmp_path / "none.json") == {}
    assert recall(tmp_path) == {}


def test_what_cannot_be_written_is_no_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    remember(tmp_path / "file" / "memory.json", {})
    remember(tmp_path / "folder", {})
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder"]
