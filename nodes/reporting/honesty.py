"""What a page must say before it shows anything: simulated parts and notices of the origins."""

from nodes.geometry.origin import Origin

SIMULATED = "simulated: "
"""How the warning about a simulated product begins; the page raises a banner for it."""


def warnings_of(*origins: Origin) -> tuple[str, ...]:
    """Return the warnings that products of these origins carry, what is simulated first."""
    simulated = [SIMULATED + origin.source for origin in origins if origin.simulated]
    notices = [notice for origin in origins for notice in origin.notices]
    return tuple(dict.fromkeys(simulated + notices))


def gather_warnings(
    groups: tuple[tuple[str, ...], ...],
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return (what is simulated, all other warnings) of several groups, each said once."""
    said = dict.fromkeys(warning for group in groups for warning in group)
    simulated = tuple(text for text in said if text.startswith(SIMULATED))
    return simulated, tuple(text for text in said if text not in simulated)
