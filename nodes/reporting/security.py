"""What a page may run and reach: its own scripts, and nothing outside."""

from base64 import b64encode
from hashlib import sha256

from nodes.reporting.artefacts import Section
from nodes.reporting.assets import read_asset


def collect_scripts(sections: tuple[Section, ...]) -> tuple[str, ...]:
    """Return the sources of the scripts that the sections need, each once."""
    names = dict.fromkeys(name for section in sections for name in section.scripts)
    return tuple(read_asset(f"{name}.js") for name in names)


def content_policy(scripts: tuple[str, ...]) -> str:
    """Return a Content-Security-Policy (W3C CSP 3) for a page with these inline scripts.

    No request may leave, and only scripts with one of these hashes run: text that slipped through
    as a script would stay dead.
    """
    digests = [b64encode(sha256(code.encode()).digest()).decode() for code in scripts]
    allowed = " ".join(f"'sha256-{digest}'" for digest in digests) or "'none'"
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src {allowed}",
            "style-src 'unsafe-inline'",
            "img-src data: blob:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )


def safe_link(link: str) -> str:
    """Return a relative link unchanged, and "" for one that leads elsewhere or runs a script."""
    elsewhere = ":" in link or link.startswith(("/", "\\"))
    return "" if elsewhere else link
