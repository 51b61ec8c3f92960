"""Pages as one HTML file, and the sections that they are built from as JSON."""

import json
from collections.abc import Mapping
from dataclasses import asdict

from nodes.reporting.artefacts import Page, Section


class PageFormat:
    """`page.html`, whole in itself."""

    @staticmethod
    def encode(value: Page) -> dict[str, bytes]:
        """Return the one file of a page."""
        return {"page.html": value.html.encode("utf-8")}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> Page:
        """Return the page of `encode`."""
        return Page(files["page.html"].decode("utf-8"))


class SectionFormat:
    """`section.json` with the fields of a section."""

    @staticmethod
    def encode(value: Section) -> dict[str, bytes]:
        """Return the one file of a section."""
        return {"section.json": json.dumps(asdict(value), ensure_ascii=False).encode("utf-8")}

    @staticmethod
    def decode(files: Mapping[str, bytes]) -> Section:
        """Return the section of `encode`."""
        fields = json.loads(files["section.json"])
        fields["warnings"], fields["scripts"] = tuple(fields["warnings"]), tuple(fields["scripts"])
        return Section(**fields)
