"""What C libraries print on standard error: heard here, and shown to nobody.

ITK quotes the names of files there, which may be names of patients; and some decoders tell of
damaged pixels nowhere else.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from tempfile import TemporaryFile


@contextmanager
def native_words() -> Iterator[Callable[[], bytes]]:
    """Take what is written on standard error meanwhile; yield a function that returns it."""
    with TemporaryFile() as words:
        kept = os.dup(2)
        os.dup2(words.fileno(), 2)
        try:
            yield lambda: os.pread(words.fileno(), os.fstat(words.fileno()).st_size, 0)
        finally:
            os.dup2(kept, 2)
            os.close(kept)
