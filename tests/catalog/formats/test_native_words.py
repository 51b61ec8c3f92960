"""What is written on standard error below Python is heard and not shown."""

import os

import pytest

from catalog.formats.native_words import native_words


def test_words_are_heard_and_not_shown(capfd):
    with native_words() as words:
        os.write(2, b"JANE DOE is corrupt")
        assert words() == b"JANE DOE is corrupt"
    os.write(2, b"after")
    assert capfd.readouterr().err == "after"


def test_standard_error_comes_back_after_an_error(capfd):
    with pytest.raises(KeyError), native_words():
        os.write(2, b"lost")
        raise KeyError
    os.write(2, b"after")
    assert capfd.readouterr().err == "after"
