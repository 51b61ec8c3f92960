"""Compiled kernels follow their sources, also across files."""

from pathlib import Path

import pytest

from pipelines.kernel_cache import VARIABLE, drop_old_kernels, use_kernel_cache

CALLER = """
    from numba import njit
    from nodes.kernels.inner import add

    @njit(cache=True)
    def twice(x):
        return add(add(x))
"""
INNER = """
    from numba import njit

    @njit(cache=True)
    def add(x):
        return x + 1
"""
NODE = """
    from nodes.toy.parameters import CountParameters

    def count_up(seed_file: dict, parameters: CountParameters) -> dict:
        '''Count from a start.'''
        from nodes.kernels.caller import twice
        return {"values": [float(twice(seed_file["start"])) for n in range(parameters.count)]}
"""


def write_kernels(toy) -> None:
    import textwrap

    for name, text in (
        ("kernels/caller", CALLER),
        ("kernels/inner", INNER),
        ("toy/count_up", NODE),
    ):
        toy.write(f"nodes/{name}.py", textwrap.dedent(text))


def test_an_edit_in_a_kernel_that_another_calls_is_computed_anew(toy) -> None:
    write_kernels(toy)
    toy.run()
    assert toy.total() == 2 * 4 * 3.0
    assert list((toy.root / "data/kernels").rglob("*.nbc"))
    toy.edit("nodes/kernels/inner.py", "x + 1", "x + 5")
    toy.run()
    assert toy.total() == 2 * 4 * 11.0


def test_cleaning_drops_what_earlier_kernels_left(toy) -> None:
    write_kernels(toy)
    toy.run()
    (old,) = (toy.root / "data/kernels").iterdir()
    toy.edit("nodes/kernels/inner.py", "x + 1", "x + 5")
    toy.run()
    toy.call("clean")
    (new,) = (toy.root / "data/kernels").iterdir()
    assert new != old


def test_a_folder_of_the_persons_own_stays(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "mine"))
    assert use_kernel_cache(tmp_path) == tmp_path / "mine"
    drop_old_kernels(tmp_path)  # nothing there is no error
