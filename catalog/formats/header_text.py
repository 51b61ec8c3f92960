"""Text as one line of plain ASCII, for the headers and file names of field formats."""

import json
from dataclasses import asdict
from urllib.parse import quote, unquote

from nodes.geometry.origin import Origin

# All that headers and file names carry unharmed; "%", "/", "\\" and what is not ASCII are quoted.
_PLAIN = " !\"#$&'()*+,-.:;<=>?@[]^_`{|}~"


def to_ascii(text: str) -> str:
    """Return the text with every other character percent-quoted (RFC 3986).

    So are spaces at the ends, which headers lose.
    """
    inner = text.strip(" ")
    start = len(text) - len(text.lstrip(" "))
    end = len(text) - start - len(inner)
    return "%20" * start + quote(inner, safe=_PLAIN) + "%20" * end


def from_ascii(text: str) -> str:
    """Return the text of `to_ascii`."""
    return unquote(text)


def origin_to_text(origin: Origin) -> str:
    """Return an artefact's origin as one line of ASCII."""
    return to_ascii(json.dumps(asdict(origin)))


def origin_from_text(text: str) -> Origin:
    """Return the origin of `origin_to_text`."""
    fields = json.loads(from_ascii(text))
    return Origin(fields["source"], fields["simulated"], tuple(fields["notices"]))
