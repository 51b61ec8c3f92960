"""What a PLY file says about itself: axes, unit, source, what is simulated, as comments."""

from catalog.formats.header_text import origin_from_text, origin_to_text
from nodes.geometry.origin import Origin

_ORIGIN = "comment origin "


def add_comments(content: bytes, origin: Origin, further: tuple[str, ...] = ()) -> bytes:
    """Return the file with comments behind the two lines that every PLY file begins with.

    3D Slicer takes the axes of a model from the first "SPACE=" in its comments, and readers take
    the word that ends the header for its end even within a comment: neither may come from a text.
    """
    comments = (
        "comment SPACE=LPS",
        "comment frame patient (x left, y posterior, z superior)",
        "comment unit mm",
        f"comment simulated {'yes' if origin.simulated else 'no'}",
        *(f"comment {_harmless(line)}" for line in further),
        _ORIGIN + _harmless(origin_to_text(origin)),
    )
    first, second, rest = content.split(b"\n", 2)
    return b"\n".join([first, second, *(line.encode("ascii") for line in comments), rest])


def _harmless(text: str) -> str:
    return text.replace("end_header", "end%5Fheader").replace("SPACE=", "SPACE%3D")


def read_origin(content: bytes) -> Origin:
    """Return the origin that `add_comments` wrote."""
    header = content.partition(b"end_header")[0].decode("ascii")
    lines = [line for line in header.splitlines() if line.startswith(_ORIGIN)]
    return origin_from_text(lines[0].removeprefix(_ORIGIN))
