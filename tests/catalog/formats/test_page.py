"""Pages and sections come back as they were."""

from hypothesis import given
from hypothesis import strategies as st

from catalog.formats.page import PageFormat, SectionFormat
from nodes.reporting.artefacts import Page, Section
from tests.catalog.formats.hostile import TEXTS


@given(TEXTS)
def test_a_page_comes_back_to_the_last_line_end(html: str) -> None:
    files = PageFormat.encode(Page(html))
    assert PageFormat.decode(files) == Page(html)
    assert files["page.html"].decode("utf-8") == html


@given(TEXTS, TEXTS, st.lists(TEXTS).map(tuple), st.lists(TEXTS).map(tuple))
def test_a_section_comes_back(title: str, html: str, warnings: tuple, scripts: tuple) -> None:
    section = Section(title, html, warnings, scripts)
    assert SectionFormat.decode(SectionFormat.encode(section)) == section
