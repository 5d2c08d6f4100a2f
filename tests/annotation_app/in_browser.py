"""What tests in a real browser share: the browser, and a server at a port."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, TypeVar

import pytest
from axe_playwright_python.sync_playwright import Axe
from flask import Flask
from playwright.sync_api import Browser, BrowserContext, Page, Route, expect, sync_playwright
from werkzeug.serving import make_server

from tests.annotation_app import firefox_relay
from tests.annotation_app.browser import session_of
from tests.annotation_app.conftest import PATIENCE_MS
from tests.chromium import CHROMIUM

FIREFOX = shutil.which("firefox") or shutil.which("firefox-esr")
T = TypeVar("T")

SMALLEST_PX = 8
STEP_MS = 50
SERIOUS = ("serious", "critical")
ANY = ("minor", "moderate", *SERIOUS)
"""What axe finds, however little it matters."""
PICTURES = os.environ.get("CT_PICTURES")
"""A folder for pictures of the pages, if somebody wants to look at them."""
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"]


UNDER_A_BAR = """one => {
  const box = one.getBoundingClientRect();
  return [box.top + 2, box.bottom - 2].some(y => {
    let over = document.elementFromPoint((box.left + box.right) / 2, y);
    while (over && !/sticky|fixed/.test(getComputedStyle(over).position)) over = over.parentElement;
    return over && !over.contains(one);
  });
}"""


@contextmanager
def launched(kind: str = "chromium") -> Iterator[Browser]:
    """A browser: Chromium, or the Firefox that is installed, driven by WebDriver BiDi."""
    file = {"chromium": CHROMIUM, "firefox": FIREFOX}[kind]
    if file is None:
        pytest.skip(f"{kind.title()} is not installed")
    expect.set_options(timeout=PATIENCE_MS)
    with sync_playwright() as playwright, TemporaryDirectory() as folder:
        if kind == "firefox":
            start = _relayed(file, Path(folder) / "firefox")
            browser = playwright.firefox.launch(
                executable_path=start,
                channel="moz-firefox",
                firefox_user_prefs=firefox_relay.PREFERENCES,
            )
        else:
            browser = playwright.chromium.launch(executable_path=file, args=FLAGS)
        yield browser
        browser.close()


def _relayed(firefox: str, script: Path) -> Path:
    """Write a script that runs Firefox behind the relay, and takes Firefox's arguments."""
    words = shlex.join([sys.executable, firefox_relay.__file__, firefox])
    script.write_text(f'#!/bin/sh\nexec {words} "$@"\n')
    script.chmod(0o700)
    return script


def sign_in(context: BrowserContext, person: Any, url: str) -> None:
    """Make a context's pages those of somebody who has signed in."""
    context.add_cookies([{"name": "session", "value": session_of(person), "url": url}])


def look(page: Page, name: str, impacts: tuple[str, ...] = ANY) -> list[str]:
    """What axe finds on a telephone and on a screen; nothing may be wider than the window."""
    found: list[str] = []
    for width, height in ((390, 844), (1280, 800)):
        page.set_viewport_size({"width": width, "height": height})
        found += violations(page, impacts)
        assert width_of(page) <= width, name
        if PICTURES:
            page.screenshot(path=Path(PICTURES) / f"{name}-{width}.png", full_page=True)
    return found


def schemes(page: Page) -> tuple[Literal["light", "dark"], ...]:
    """The schemes that a test can ask a browser for: Playwright can't darken Firefox's pages."""
    browser = page.context.browser
    is_firefox = browser is not None and browser.browser_type.name == "firefox"
    return ("light",) if is_firefox else ("light", "dark")


def violations(page: Page, impacts: tuple[str, ...] = SERIOUS, **options: object) -> list[str]:
    """What axe-core finds wrong with a page, once it has come."""
    page.wait_for_load_state()
    if not page.evaluate("'axe' in window"):
        page.evaluate(Axe().axe_script)
    found = page.evaluate(
        "options => axe.run(options).then(result => result.violations.map("
        "v => [v.impact, `${v.id}: ${v.nodes[0].html.slice(0, 200)}`]))",
        {"resultTypes": ["violations"], "selectors": False, **options},
    )
    return [f"{page.url}: {what}" for impact, what in found if impact in impacts]


def errors_of(page: Page) -> list[str]:
    """What the page's scripts and the browser's console complain of, from now on."""
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(f"{page.url}: {error}"))
    page.on("console", lambda m: errors.append(f"{page.url}: {m.text}") if m.type == "error" else 0)
    return errors


@contextmanager
def late(page: Page, name: str) -> Iterator[None]:
    """Have what a page asks for next by a name go at the end of the block: a slow network."""
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route)

    page.route(f"**/{name}", hold, times=1)
    yield
    while not held:
        page.wait_for_timeout(10)
    held.pop().continue_()


def drawn_anew(page: Page) -> None:
    """Wait until the page has drawn what a new size or a click has changed."""
    frame = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
    page.evaluate(frame)


def becomes(page: Page, read: Callable[[], T], expected: T) -> None:
    """Wait until what is read of a page is as it should be."""
    for _ in range(PATIENCE_MS // STEP_MS):
        if read() == expected:
            return
        page.wait_for_timeout(STEP_MS)
    assert read() == expected


def width_of(page: Page) -> int:
    """How wide a page is, in pixels, with what doesn't fit the window."""
    return int(page.evaluate("document.documentElement.scrollWidth"))


def out_of_sight(page: Page, *selectors: str) -> list[str]:
    """What of these isn't wholly in the window, is under a bar, or isn't there, with its box."""
    size = page.viewport_size
    assert size is not None
    wrong = []
    for selector in selectors:
        box = page.locator(selector).first.bounding_box()
        if (
            box is None
            or box["width"] < SMALLEST_PX
            or min(box["x"], box["y"]) < 0
            or box["x"] + box["width"] > size["width"]
            or box["y"] + box["height"] > size["height"]
            or page.locator(selector).first.evaluate(UNDER_A_BAR)
        ):
            wrong.append(f"{page.url}: {selector} {box}")
    return wrong


@contextmanager
def serving(app: Flask) -> Iterator[str]:
    """The address of an app that is served in a thread."""
    server = make_server("127.0.0.1", 0, app, threaded=True)
    thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    thread.join()
    server.server_close()
