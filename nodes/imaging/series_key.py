"""How a series is named without telling its identifier.

A series instance UID leads to a patient. It is hashed at the door, also where a person writes it
as a parameter, so that neither artefacts nor keys, records and pages ever hold it.
"""

import hashlib
import re

# 32 bits tell the series of a folder apart, and are too few to find a UID by trying.
_DIGITS = 8
_NUMBER_OR_KEY = re.compile(rf"(|[1-9][0-9]{{0,4}}|s[0-9a-f]{{{_DIGITS}}})")


def series_key(uid: str) -> str:
    """Return "s" and the first digits of the UID's SHA-256."""
    return "s" + hashlib.sha256(uid.strip().encode()).hexdigest()[:_DIGITS]


def name_series(written: object) -> str:
    """Return how a person named a series: "", a number, a key; all else is a UID and is hashed."""
    text = str(written).strip()
    return text if _NUMBER_OR_KEY.fullmatch(text) else series_key(text)
