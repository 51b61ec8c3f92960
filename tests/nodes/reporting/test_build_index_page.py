import re
from html import unescape

import pytest

from nodes.reporting.artefacts import CaseLine
from nodes.reporting.build_index_page import build_index_page

COMPLETE = CaseLine("p002", "Chest CT", "anatomy", "complete", "2025-01-03", 33.4, "p002.html")
NEVER = CaseLine("head", "Head MRI", "anatomy", "never run", "", 0.0, "")


def test_every_case_is_told_with_status_time_and_link():
    html = build_index_page(cases=(COMPLETE, NEVER)).html
    assert '<a href="p002.html">Chest CT</a>' in html
    text = unescape(re.sub(r"<[^>]*>", " ", html))
    for word in ("complete", "33 s", "2025-01-03", "Head MRI", "never run", "2 cases"):
        assert word in text
    assert len(re.findall("<a ", html)) == 1


def test_warnings_of_a_case_are_shown_with_what_is_simulated_first():
    warned = CaseLine("a", "A", "p", "complete", "", 1.0, "", ("Thick.", "simulated: a phantom"))
    html = build_index_page(cases=(warned,)).html
    assert html.index("simulated: a phantom") < html.index("1 warning<") < html.index("Thick.")


def test_no_time_is_told_where_none_was_taken():
    failed = CaseLine("a", "A", "p", "failed", "2025-01-03", 0.0, "")
    assert "0 ms" not in build_index_page(cases=(failed,)).html


@pytest.mark.parametrize(
    "link",
    [
        "javascript:alert(1)",
        "https://example.org/",
        "//example.org",
        "/etc/passwd",
        "\\\\server\\x",
    ],
)
def test_a_link_that_leads_elsewhere_is_no_link(link):
    html = build_index_page(cases=(CaseLine("a", "A", "p", "complete", "", 1.0, link),)).html
    assert "<a " not in html


def test_no_case_is_said(hostile):
    assert "No case" in build_index_page(cases=()).html


def test_texts_stay_text(hostile):
    case = CaseLine(hostile, hostile, hostile, hostile, hostile, 1.0, "a.html", (hostile,))
    assert "<script" not in build_index_page(cases=(case,)).html
