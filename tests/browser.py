"""A headless Chromium for tests of pages: `open_page(html or path)` gives a page that is watched.

Playwright's synchronous interface keeps an event loop running in its thread, in which no other test
could start one (Prefect does). So it lives in a thread of its own, and tests hold stand-ins.
"""

import io
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

COMMANDS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
"""No sandbox, since a container's root has none; WebGL in software, alike on every machine."""

INSIDE = ("file:", "data:", "blob:", "about:")


class StandIn:
    """Stands for a playwright object; every use of it happens in playwright's own thread."""

    def __init__(self, target: object, run: Callable) -> None:
        self._target, self._run = target, run

    def __getattr__(self, name: str) -> object:
        return self._wrap(self._run(getattr, self._target, name))

    def _wrap(self, value: object) -> object:
        if type(value).__module__.startswith("playwright"):
            return StandIn(value, self._run)
        if isinstance(value, list):
            return [self._wrap(item) for item in value]
        if callable(value):
            return lambda *args, **named: self._wrap(self._run(value, *args, **named))
        return value


@dataclass
class Watched:
    """What a page did besides showing: errors, and requests that left the machine's files."""

    console_errors: list[str] = field(default_factory=list)
    page_errors: list[str] = field(default_factory=list)
    requests_outside: list[str] = field(default_factory=list)

    def note_message(self, message) -> None:
        if message.type == "error":
            self.console_errors.append(message.text)

    def note_request(self, request) -> None:
        if not request.url.startswith(INSIDE):
            self.requests_outside.append(request.url)


class WatchedPage(StandIn):
    """A playwright page (`evaluate`, `locator`, `keyboard`, ...) with what it did in `watched`."""

    def __init__(self, target: object, run: Callable, watched: Watched) -> None:
        super().__init__(target, run)
        self.watched = watched

    def assert_quiet(self) -> None:
        """No error, no request that leaves."""
        assert self.watched == Watched()

    def wait_until_ready(self) -> None:
        """Wait until every viewer on the page has shown its first picture."""
        self.wait_for_function("() => !document.querySelector('[data-state=loading]')")
        self.settle()

    def settle(self) -> None:
        """Wait until what was asked to be drawn is drawn."""
        self.evaluate("() => new Promise(go => requestAnimationFrame(() => setTimeout(go, 30)))")

    def picture(self, selector: str) -> np.ndarray:
        """Return what one element looks like, as (rows, columns, 3) uint8."""
        from PIL import Image

        png = self.locator(selector).screenshot()
        return np.array(Image.open(io.BytesIO(png)).convert("RGB"))


@pytest.fixture(scope="session")
def browser() -> Iterator[tuple[object, Callable]]:
    """One Chromium for the session, and the function that runs in its thread."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    command = next(filter(None, map(shutil.which, COMMANDS)), None)
    if command is None:
        pytest.skip(f"no browser: none of {', '.join(COMMANDS)} is installed")
    with ThreadPoolExecutor(max_workers=1) as thread:

        def run(function: Callable, *args: object, **named: object) -> object:
            return thread.submit(function, *args, **named).result()

        driver = run(lambda: sync_api.sync_playwright().start())
        try:
            chromium = run(lambda: driver.chromium.launch(executable_path=command, args=ARGUMENTS))
            yield chromium, run
            run(chromium.close)
        finally:
            run(driver.stop)


def serve_pages(browser: tuple, folder: Path) -> Iterator[Callable[..., WatchedPage]]:
    """Yield `open_page(html or path, width, height, dark)`; at the end close what it opened."""
    chromium, run = browser
    contexts = []

    def open_page(
        page: str | Path, width: int = 1200, height: int = 900, dark: bool = False
    ) -> WatchedPage:
        path = page if isinstance(page, Path) else folder / f"page_{len(contexts)}.html"
        if isinstance(page, str):
            path.write_text(page, encoding="utf-8")
        watched = Watched()

        def start():
            context = chromium.new_context(
                viewport={"width": width, "height": height},
                color_scheme="dark" if dark else "light",
            )
            contexts.append(context)
            opened = context.new_page()
            opened.on("console", watched.note_message)
            opened.on("pageerror", lambda error: watched.page_errors.append(str(error)))
            opened.on("request", watched.note_request)
            opened.goto(path.resolve().as_uri())
            return opened

        return WatchedPage(run(start), run, watched)

    yield open_page
    for context in contexts:
        run(context.close)


@pytest.fixture
def open_page(browser: tuple, tmp_path: Path) -> Iterator[Callable[..., WatchedPage]]:
    """Open pages that one test has for itself."""
    yield from serve_pages(browser, tmp_path)


@pytest.fixture(scope="module")
def open_shared_page(
    browser: tuple, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Callable[..., WatchedPage]]:
    """Open pages that the tests of a module share: WebGL takes a second to start in software."""
    yield from serve_pages(browser, tmp_path_factory.mktemp("pages"))
