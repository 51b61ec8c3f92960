"""Content hashes are those of the bytes, and no change of a file escapes the memory of them."""

import hashlib
import json
import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from catalog.signatures import Signatures, hash_files, read_files

FILES = {"a.bin": b"first", "folder/b.bin": b"", "folder/deep/é.bin": b"x" * 3_000_000}


def write(folder: Path, files: dict[str, bytes]) -> Path:
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return folder


def by_hand(files: dict[str, bytes]) -> str:
    """The hash as its documentation says it, computed another way."""
    outer = hashlib.new("sha256")
    for name, data in sorted(files.items()):
        outer.update(name.encode() + b"\x00" + hashlib.sha256(data).hexdigest().encode() + b"\n")
    return outer.hexdigest()


def settle(path: Path, memory: Path) -> Signatures:
    """Hash when the last change is long ago, and return the memory that trusts the hash."""
    later = time.time_ns() + 10**10
    signatures = Signatures(memory)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(time, "time_ns", lambda: later)
        signatures.hash_path(path)
    signatures.save()
    return Signatures(memory)


@pytest.fixture
def memory(tmp_path: Path) -> Path:
    return tmp_path / "memory.json"


def test_files_on_disk_and_bytes_in_memory_have_one_hash(tmp_path: Path, memory: Path) -> None:
    folder = write(tmp_path / "x", FILES)
    assert Signatures(memory).hash_path(folder) == hash_files(FILES) == by_hand(FILES)
    assert read_files(folder) == FILES
    one = {"a.bin": FILES["a.bin"]}
    assert Signatures(memory).hash_path(folder / "a.bin") == by_hand(one)
    assert read_files(folder / "a.bin") == one


@settings(max_examples=40)
@given(*[st.dictionaries(st.text("ab./\n", min_size=1), st.binary(max_size=3), max_size=3)] * 2)
def test_hashes_are_equal_only_where_names_and_bytes_are(one: dict, two: dict) -> None:
    assert (hash_files(one) == hash_files(two)) == (one == two)


def test_the_same_content_elsewhere_has_the_same_hash(tmp_path: Path, memory: Path) -> None:
    signatures = Signatures(memory)
    hashes = {signatures.hash_path(write(tmp_path / name, FILES)) for name in ("x", "y/z")}
    assert len(hashes) == 1


def rewrite(folder: Path) -> None:
    (folder / "a.bin").write_bytes(b"FIRST")


def rewrite_in_disguise(folder: Path) -> None:
    before = (folder / "a.bin").stat()
    rewrite(folder)
    os.utime(folder / "a.bin", ns=(before.st_atime_ns, before.st_mtime_ns))


def replace_in_disguise(folder: Path) -> None:
    before = (folder / "a.bin").stat()
    (folder / "new").write_bytes(b"FIRST")
    os.utime(folder / "new", ns=(before.st_atime_ns, before.st_mtime_ns))
    (folder / "new").replace(folder / "a.bin")


def swap(folder: Path) -> None:
    for old, new in (("a.bin", "t"), ("folder/b.bin", "a.bin"), ("t", "folder/b.bin")):
        (folder / old).rename(folder / new)


def move_folder_aside(folder: Path) -> None:
    """Another folder, older than what is remembered, takes the place of the first."""
    folder.rename(folder.with_name("aside"))
    folder.with_name("older").rename(folder)


CHANGES = [
    rewrite,
    rewrite_in_disguise,
    replace_in_disguise,
    swap,
    move_folder_aside,
    lambda folder: (folder / "a.bin").rename(folder / "c.bin"),
    lambda folder: (folder / "new.bin").write_bytes(b""),
    lambda folder: (folder / "a.bin").unlink(),
]


@pytest.mark.parametrize("change", CHANGES)
def test_every_change_is_seen(
    tmp_path: Path, memory: Path, change: Callable[[Path], object]
) -> None:
    write(tmp_path / "older", {"a.bin": b"other", "folder/b.bin": b""})
    folder = write(tmp_path / "x", {"a.bin": b"first", "folder/b.bin": b""})
    signatures = settle(folder, memory)
    before = signatures.hash_path(folder)
    change(folder)
    assert signatures.hash_path(folder) != before
    assert signatures.hash_path(folder) == by_hand(read_files(folder))


def test_what_nothing_touched_is_not_read_again(
    tmp_path: Path, memory: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write(tmp_path / "x", FILES)
    signatures = settle(folder, memory)
    monkeypatch.setattr("catalog.signatures._hash_file", lambda file: pytest.fail(file))
    assert signatures.hash_path(folder) == by_hand(FILES)
    with pytest.raises(pytest.fail.Exception):
        signatures.hash_path(folder, again=True)


def test_a_change_within_the_tick_after_hashing_is_seen(
    tmp_path: Path, memory: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on a disk whose clock ticks in seconds: neither time nor size nor inode tell."""
    folder = write(tmp_path / "x", {"a.bin": b"first"})
    now = time.time_ns() // 10**9 * 10**9
    real = os.stat

    class Coarse:
        def __init__(self, path: str) -> None:
            s = real(path)
            self.st_size, self.st_ino, self.st_mode = s.st_size, s.st_ino, s.st_mode
            self.st_mtime_ns = self.st_ctime_ns = now

    monkeypatch.setattr("catalog.signatures.os.stat", lambda path, **_: Coarse(path))
    signatures = Signatures(memory)
    before = signatures.hash_path(folder)
    (folder / "a.bin").write_bytes(b"FIRST")
    assert signatures.hash_path(folder) != before


def test_a_change_while_it_is_hashed_is_seen_next_time(
    tmp_path: Path, memory: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write(tmp_path / "x", {"a.bin": b"first"})
    signatures = settle(folder, memory)
    (folder / "a.bin").touch()
    real = hashlib.file_digest

    def hash_then_change(file: str) -> str:
        with open(file, "rb") as stream:
            digest = real(stream, "sha256").hexdigest()
        (folder / "a.bin").write_bytes(b"FIRST")
        return digest

    with monkeypatch.context() as patch:
        patch.setattr("catalog.signatures._hash_file", hash_then_change)
        assert signatures.hash_path(folder) == by_hand({"a.bin": b"first"})
    assert signatures.hash_path(folder) == by_hand({"a.bin": b"FIRST"})


def test_what_is_not_there_has_no_hash(tmp_path: Path, memory: Path) -> None:
    signatures = Signatures(memory)
    (tmp_path / "empty/inner").mkdir(parents=True)
    assert signatures.hash_path(tmp_path / "none") is None
    assert signatures.hash_path(tmp_path / "empty") is None
    folder = write(tmp_path / "x", FILES)
    assert signatures.hash_path(folder) is not None
    folder.rename(tmp_path / "y")
    assert signatures.hash_path(folder) is None


def test_hidden_files_and_folders_do_not_count(tmp_path: Path, memory: Path) -> None:
    folder = write(tmp_path / "x", FILES)
    write(folder, {".DS_Store": b"1", ".git/config": b"2", "folder/.hidden": b"3"})
    assert Signatures(memory).hash_path(folder) == by_hand(FILES)
    assert read_files(folder) == FILES


def test_links_count_as_what_they_point_to(tmp_path: Path, memory: Path) -> None:
    real = write(tmp_path / "real", FILES)
    linked = tmp_path / "linked"
    (linked).mkdir()
    (linked / "a.bin").symlink_to(real / "a.bin")
    (linked / "folder").symlink_to(real / "folder")
    (tmp_path / "whole").symlink_to(real)
    signatures = Signatures(memory)
    assert (
        signatures.hash_path(linked) == by_hand(FILES) == signatures.hash_path(tmp_path / "whole")
    )
    assert read_files(linked) == FILES
    (real / "folder/b.bin").write_bytes(b"new")
    assert signatures.hash_path(linked) == by_hand(read_files(real))


def test_a_link_that_leads_back_ends(tmp_path: Path, memory: Path) -> None:
    folder = write(tmp_path / "x", FILES)
    (folder / "folder/loop").symlink_to(folder)
    (folder / "self").symlink_to(".")
    assert Signatures(memory).hash_path(folder) == by_hand(FILES)


DAMAGED = ["", "[]", "{", "null", "\udcff", "[" * 100_000]
DAMAGED += [f'{{"PATH": {v}}}' for v in ("null", "[]", "5", '"abc"', "[1, 2]", '{"1": 2}')]


@pytest.mark.parametrize("text", DAMAGED, ids=range(len(DAMAGED)))
def test_a_damaged_memory_costs_only_time(tmp_path: Path, memory: Path, text: str) -> None:
    folder = write(tmp_path / "x", FILES)
    place = hashlib.sha256(os.fsencode(folder)).hexdigest()
    written = text.replace("PATH", place)
    memory.write_text(written, errors="surrogateescape")
    signatures = Signatures(memory)
    assert signatures.hash_path(folder) == by_hand(FILES)
    signatures.save()
    assert list(json.loads(memory.read_text())) == [place]


@pytest.mark.parametrize("obstacle", ["folder in its place", "file as its folder", "full disk"])
def test_a_memory_that_cannot_be_written_costs_only_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, obstacle: str
) -> None:
    folder = write(tmp_path / "x", FILES)
    memory = tmp_path / "store" / "memory.json"
    if obstacle == "folder in its place":
        memory.mkdir(parents=True)
    elif obstacle == "file as its folder":
        memory.parent.write_text("")
    else:
        monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError(28, "full")))
    signatures = Signatures(memory)
    assert signatures.hash_path(folder) == by_hand(FILES)
    signatures.save()
    assert not [p for p in tmp_path.glob("store/*") if p != memory]


def test_the_memory_names_no_path_since_folders_are_named_after_patients(
    tmp_path: Path, memory: Path
) -> None:
    signatures = Signatures(memory)
    signatures.hash_path(write(tmp_path / "Doe_Jane", {"Jane.dcm": b"1"}))
    signatures.save()
    assert "Jane" not in memory.read_text()
    signatures.forget()
    assert not memory.exists()


def test_names_that_are_no_utf8_are_hashed(tmp_path: Path, memory: Path) -> None:
    folder = write(tmp_path / "x", {"a": b"1"})
    Path(os.fsdecode(os.fsencode(folder) + b"/\xff")).write_bytes(b"2")
    signatures = Signatures(memory)
    assert signatures.hash_path(folder) == hash_files(read_files(folder))
    signatures.save()
