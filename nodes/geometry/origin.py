"""Where a product comes from and what is simulated in it; carried by every artefact."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Origin:
    """Source and honesty of an artefact.

    Parameters
    ----------
    source : str
        What it was made from, in plain words and without any patient's identifier.
    simulated : bool
        True where any part of it is simulated; inherited by all that is made from it.
    notices : tuple of str
        What a reader must know: corrections, assumptions, estimates.
    """

    source: str
    simulated: bool = False
    notices: tuple[str, ...] = ()

    def with_notice(self, *notices: str) -> "Origin":
        """Return a copy with further notices, each kept once."""
        return replace(self, notices=tuple(dict.fromkeys(self.notices + notices)))
