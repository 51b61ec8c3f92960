"""Whole pages in a real browser: quiet, closed to the outside, and fitting wide and narrow."""

from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

import numpy as np
import pandas
import pytest

from nodes.geometry.meshes import Surfaces
from nodes.geometry.origin import Origin
from nodes.geometry.sites import Sites
from nodes.reporting.artefacts import CaseLine
from nodes.reporting.build_index_page import build_index_page
from nodes.reporting.show_entries import show_entries
from nodes.reporting.show_sites import show_sites
from nodes.reporting.show_slices import show_slices
from nodes.reporting.show_surfaces import show_surfaces
from nodes.reporting.show_table import show_table
from nodes.reporting.show_volume import show_volume


@pytest.fixture
def sections(balls, box_with_ball, defaults):
    """One section of each kind."""
    table = pandas.DataFrame({"label": ["left_lung"], "volume_ml": [268.1], "parts": [1]})
    sites = Sites(("start",), np.eye(4)[None], ("target",), np.ones((1, 3)))
    places = [f"{place}_{axis}_mm" for place in ("skin", "pleura") for axis in "xyz"]
    row = [(1, "right 5", 100.0, 0.0, 0.0, 60.0, 0.0, 0.0, 31.5, 7.2)]
    columns = ["number", "window", *places, "wall_thickness_mm", "bone_clearance_mm"]
    entries = pandas.DataFrame(row, columns=columns)
    return (
        show_surfaces(balls, defaults("show_surfaces")),
        show_sites(balls, sites, defaults("show_sites")),
        show_entries(balls, box_with_ball[1], entries, defaults("show_entries")),
        show_slices(*box_with_ball, defaults("show_slices")),
        show_volume(box_with_ball[0], defaults("show_volume")),
        show_table(table, defaults("show_measures")),
    )


def overflow(page):
    return page.evaluate("document.documentElement.scrollWidth - window.innerWidth")


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("width", [1200, 390])
def test_case_page_is_quiet_and_fits(show, sections, width, dark):
    page = show(*sections, width=width, dark=dark)
    page.assert_quiet()
    assert overflow(page) <= 0
    assert page.evaluate("document.querySelectorAll('[data-state=ready]').length") == 5
    paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (sum(map(int, paper[4:-1].split(","))) < 300) is dark
    shown = page.evaluate("getComputedStyle(document.querySelector('.pipeline.wide')).display")
    assert (shown == "none") is (width == 390)


@pytest.mark.parametrize("width", [1200, 390])
def test_index_page_is_quiet_and_fits(open_page, width):
    simulated = ("simulated: x",)
    cases = (
        CaseLine("a", "A", "anatomy", "complete", "2025-01-03", 33.0, "a.html", simulated),
        CaseLine("b" * 60, "B" * 90, "anatomy", "failed", "2025-01-03", 3.0, ""),
    )
    page = open_page(build_index_page(cases=cases).html, width=width)
    page.assert_quiet()
    assert overflow(page) <= 0


@pytest.fixture
def outside():
    """A server on this machine that counts who asks it for something."""
    asked = []

    class Counter(BaseHTTPRequestHandler):
        def do_GET(self):
            asked.append(self.path)
            self.send_error(404)

        def log_message(self, *args):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Counter) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}", asked
        server.shutdown()


LEAKS = """async address => {
    const load = (tag, key, path, more) => new Promise(done => {
        const element = Object.assign(document.createElement(tag), more);
        element.onload = element.onerror = done;
        element[key] = address + path;
        document.head.append(element);
        setTimeout(done, 300);
    });
    await fetch(address + "/fetch", { mode: "no-cors" }).catch(() => 0);
    await load("img", "src", "/img");
    await load("script", "src", "/script");
    await load("link", "href", "/style", { rel: "stylesheet" });
    await load("iframe", "src", "/frame");
}"""


def test_no_request_can_leave_a_page_even_if_something_tries(show, sections, outside, open_page):
    address, asked = outside
    show(*sections).evaluate(LEAKS, address)
    assert asked == []
    open_page("<!doctype html><title>free</title>").evaluate(LEAKS, address)
    assert "/img" in asked and "/fetch" in asked  # a page without the policy does reach it


def test_a_script_that_is_not_the_pages_own_stays_dead(show, sections):
    page = show(*sections)
    page.evaluate(
        "() => { const s = document.createElement('script'); s.textContent = 'window.ran = 1';"
        " document.body.append(s); }"
    )
    assert page.evaluate("window.ran") is None


def test_hostile_text_stays_text(show, box_with_ball, balls, defaults, hostile, run_account):
    volume, label_map = box_with_ball
    origin = Origin(hostile, True, (hostile,))
    named = replace(label_map, names=(hostile, hostile + "2"), origin=origin)
    surfaces = Surfaces(((hostile, balls.meshes[0][1]),), origin)
    page = show(
        show_surfaces(surfaces, defaults("show_surfaces", title=hostile, caption=hostile)),
        show_slices(volume, named, defaults("show_slices", title=hostile)),
        show_table(
            pandas.DataFrame({hostile: [hostile]}), defaults("show_measures", title=hostile)
        ),
        account=replace(run_account, title=hostile, inputs=((hostile, hostile, ""),)),
    )
    page.assert_quiet()
    assert page.title() == hostile + " · tendril"
    assert page.evaluate("document.querySelectorAll('main b[onmouseover]').length") == 0
    names = page.evaluate("[...document.querySelectorAll('.parts label')].map(x => x.textContent)")
    assert names == [hostile, hostile, hostile + "2"]


def test_paper_is_white_even_from_a_dark_screen(show, sections):
    page = show(*sections, dark=True)
    assert page.picture(".viewer3d canvas >> nth=0")[3, 3].max() < 100
    page.emulate_media(media="print")
    page.wait_for_timeout(200)
    assert page.picture(".viewer3d canvas >> nth=0")[3, 3].min() > 240
    assert not page.locator(".windows >> nth=0").is_visible()


def test_a_short_hash_is_copied_whole(show, run_account):
    page = show()
    page.evaluate("document.querySelectorAll('details').forEach(e => { e.open = true; })")
    digest = page.locator(".hash").first
    assert digest.bounding_box()["width"] < 150
    digest.click()
    assert page.evaluate("getSelection().toString()") == run_account.inputs[0][2]
