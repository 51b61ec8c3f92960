"""The only place where planning reads the clock, for limits of time."""

import time


def now() -> float:
    """Return seconds that pass evenly, from anywhere on."""
    return time.perf_counter()
