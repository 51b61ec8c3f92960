"""Explicit Runge-Kutta-Nystroem methods for y'' = f(y), as exact fractions and as floats.

Stage k lies at `nodes[k]` of the step h: y_k = y + c_k h y' + h^2 sum_j a_kj f_j, and at its end
y + h y' + h^2 sum_k b_k f_k and y' + h sum_k d_k f_k.
"""

from fractions import Fraction
from typing import NamedTuple


class Nystroem(NamedTuple):
    """A method: `nodes` c, `stages` a (row k has k entries), `values` b, `rates` d."""

    nodes: tuple
    stages: tuple
    values: tuple
    rates: tuple


def _exact(nodes: str, stages: tuple[str, ...], values: str, rates: str) -> Nystroem:
    def row(text: str) -> tuple[Fraction, ...]:
        return tuple(Fraction(entry) for entry in text.split())

    return Nystroem(row(nodes), tuple(row(line) for line in stages), row(values), row(rates))


def _floats(method: Nystroem) -> Nystroem:
    return Nystroem(
        tuple(float(c) for c in method.nodes),
        tuple(tuple(float(a) for a in line) for line in method.stages),
        tuple(float(b) for b in method.values),
        tuple(float(d) for d in method.rates),
    )


# [Hairer1993] II.14, Nystroem's own method of order 4.
EXACT_4 = _exact("0 1/2 1", ("", "1/8", "0 1/2"), "1/6 1/3 0", "1/6 2/3 1/6")

# [Dormand1987] table 1, RKN8(6)9FM without its last stage, which only an error estimate needs.
EXACT_8 = _exact(
    "0 1/20 1/10 3/10 1/2 7/10 9/10 1",
    (
        "",
        "1/800",
        "1/600 1/300",
        "9/200 -9/100 9/100",
        "-66701/197352 28325/32892 -2665/5482 2170/24669",
        "227015747/304251000 -54897451/30425100 12942349/10141700 -9499/304251 539/9250",
        "-1131891597/901789000 41964921/12882700 -6663147/3220675 270954/644135 -108/5875 114/1645",
        "13836959/3667458 -17731450/1833729 1063919505/156478208 -33213845/39119552 13335/28544"
        " -705/14272 1645/57088",
    ),
    "223/7938 0 1175/8064 925/6048 41/448 925/14112 1175/72576 0",
    "223/7938 0 5875/36288 4625/21168 41/224 4625/21168 5875/36288 223/7938",
)

ORDER_4, ORDER_8 = _floats(EXACT_4), _floats(EXACT_8)
