"""What a page must say before it shows anything: simulated parts and notices of the origins."""

from dataclasses import dataclass

from nodes.geometry.origin import Origin

SIMULATED = "simulated: "
"""How the warning about a simulated product begins; the page raises a banner for it."""

ESTIMATED = "estimat"
"""What every notice of an estimate has in it: estimate, estimated, estimation."""


def warnings_of(*origins: Origin) -> tuple[str, ...]:
    """Return the warnings that products of these origins carry, what is simulated first.

    An origin's last notices are said before its first: they are nearest to what is shown.
    """
    simulated = [SIMULATED + origin.source for origin in origins if origin.simulated]
    notices = [notice for origin in origins for notice in reversed(origin.notices)]
    return tuple(dict.fromkeys(simulated + notices))


@dataclass(frozen=True)
class Warnings:
    """All warnings of a page by kind, each said once: what is simulated, estimated, all else.

    Parameters
    ----------
    simulated : of what was simulated itself.
    derived : of what was computed from it, whose sources name it.
    """

    simulated: tuple[str, ...]
    derived: tuple[str, ...]
    estimated: tuple[str, ...]
    others: tuple[str, ...]


def gather_warnings(groups: tuple[tuple[str, ...], ...]) -> Warnings:
    """Return the warnings of several groups by kind; an estimate is what calls itself one."""
    said = dict.fromkeys(warning.strip() for group in groups for warning in group)
    simulated = tuple(text for text in said if text.startswith(SIMULATED))
    derived = tuple(text for text in simulated if names_another(text, simulated))
    rest = tuple(text for text in said if text not in simulated)
    estimated = tuple(text for text in rest if ESTIMATED in text.lower())
    return Warnings(
        tuple(text for text in simulated if text not in derived),
        derived,
        estimated,
        tuple(text for text in rest if text not in estimated),
    )


def names_another(text: str, simulated: tuple[str, ...]) -> bool:
    """Return whether a simulated product's source has another's within it."""
    sources = (other.removeprefix(SIMULATED) for other in simulated if other != text)
    return any(source in text for source in sources)
