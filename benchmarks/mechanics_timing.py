"""How the benchmark of mechanics measures: CPU time of many calls, the median of repeats, and what
this core can do at most."""

import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numba import njit


@dataclass(frozen=True)
class Row:
    """One line of the table: time for one solve, what was asked, and the estimated limit, in us."""

    name: str
    us: float
    asked_us: float | None = None
    limit_us: float | None = None
    tip_error_mm: float | None = None
    note: str = ""

    def show(self) -> None:
        asked = f"{self.asked_us:9.3g}" if self.asked_us else " " * 9
        limit = f"{self.limit_us:9.3g} {self.us / self.limit_us:6.1f} x" if self.limit_us else ""
        error = "" if self.tip_error_mm is None else f"{self.tip_error_mm:.1e}"
        met = "" if not self.asked_us else ("yes" if self.us <= self.asked_us else "NO")
        rate = f"{1e6 / self.us:11,.0f}"
        cells = f"{self.name:47} {self.us:10.4g} {rate} {asked} {met:3} {limit:18} {error:8}"
        print(cells, self.note, flush=True)

    def record(self) -> dict[str, Any]:
        return {name: value for name, value in asdict(self).items() if value not in (None, "")}


def show_head(title: str) -> None:
    print(
        f"\n{title}\n{'':47} {'us/solve':>10} {'solves/s':>11} {'asked us':>9}"
        f"     {'limit us':>9} {'above':>8} {'error mm':8}"
    )


def cpu_us(work: Callable[[], Any], count: int, repeats: int = 15) -> float:
    """Return the median over repeats of this thread's CPU time, us, of one of `count` solves."""
    work()
    times = []
    for _ in range(repeats):
        started = time.thread_time()
        work()
        times.append(time.thread_time() - started)
    return statistics.median(times) / count * 1e6


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _multiply_add(lanes, total, times):
    """Polynomials of 128 numbers, which stay in registers and go eight at a time if they can."""
    for _ in range(times):
        for lane in range(128):
            x = lanes[lane]
            y = ((((((x + 1) * x + 2) * x + 3) * x + 4) * x + 5) * x + 6) * x + 7
            y = (((((((y * x + 1) * x + 2) * x + 3) * x + 4) * x + 5) * x + 6) * x + 7) * x + 8
            total[lane] = y
        lanes[0] += 1e-9


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _multiply_add_singly(start, factor, times):
    """Eight independent chains, one number each."""
    a, b, c, d = start, start + 1, start + 2, start + 3
    e, f, g, h = start + 4, start + 5, start + 6, start + 7
    for _ in range(times):
        a, b, c, d = a * factor + b, b * factor + 1, c * factor + 2, d * factor + 3
        e, f, g, h = e * factor + 4, f * factor + 5, g * factor + 6, h * factor + 7
    return a + b + c + d + e + f + g + h


def flops_per_us() -> tuple[float, float]:
    """Return what one core does a us: in whole vectors, and one number at a time (measured)."""
    lanes = np.linspace(0.1, 0.2, 128)
    wide = cpu_us(lambda: _multiply_add(lanes, np.empty(128), 20000), 20000)
    single = cpu_us(lambda: _multiply_add_singly(0.1, 0.5, 200000), 200000)
    return 2 * 15 * 128 / wide, 2 * 8 / single
