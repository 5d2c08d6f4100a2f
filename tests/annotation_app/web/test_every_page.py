"""Every page of the app: no error, nothing that axe finds, too wide, or from another host."""

from __future__ import annotations

import re
from collections.abc import Iterator
from urllib.parse import urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Request

from corpus_tools.importers.authored.bundled import open_corpus
from docs import make_screenshots
from docs.example_study import SCENARIOS, Example, example
from tests.annotation_app.in_browser import ANY, errors_of, serving, violations, width_of
from tests.annotation_app.pages.films import film

pytestmark = pytest.mark.slow

WIDTHS = ((1280, 800), (360, 740))
ONE_SCREEN = ("/dashboard/<study_name>",)
"""Pages that fit a computer's screen."""


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Example]:
    """What pictures are taken of, with short films instead of rendered ones."""
    contexts = open_corpus("warehouse").contexts
    folder = tmp_path_factory.mktemp("films")
    films = film(folder, SCENARIOS, lambda name, _number: contexts[name])
    with example(tmp_path_factory.mktemp("example"), films) as made:
        yield made


def test_every_page_is_accessible_and_stays_on_its_host(filled: Example, chromium: Browser) -> None:
    found: list[str] = []
    hosts: set[str] = set()
    errors: list[list[str]] = []

    def ask(request: Request) -> None:
        if not request.url.startswith(("data:", "blob:")):
            hosts.add(urlsplit(request.url).netloc)

    with serving(filled.app) as site:
        for who, cookie in filled.cookies.items():
            context = chromium.new_context(color_scheme="light", reduced_motion="reduce")
            if cookie is not None:
                context.add_cookies([{"name": "session", "value": cookie, "url": site}])
            page = context.new_page()
            page.add_init_script(Axe().axe_script)  # sent once
            page.on("request", ask)
            errors.append(errors_of(page))
            for path in [path for by, path in make_screenshots.PAGES.values() if by == who]:
                page.emulate_media(color_scheme="light")
                page.goto(site + re.sub("<[^>]+>", lambda word: filled.words[word[0]], path))
                assert page.url.endswith("/login") == (path == "/login"), path
                for width, height in WIDTHS:
                    page.set_viewport_size({"width": width, "height": height})
                    if width_of(page) > width:
                        found.append(f"{path} is {width_of(page)} pixels wide, not {width}")
                    found += violations(page, ANY)
                    if path in ONE_SCREEN and width > height:
                        long = page.evaluate("document.documentElement.scrollHeight")
                        found += [f"{path} is {long} pixels high"] if long > height else []
                page.emulate_media(color_scheme="dark")
                found += violations(page, ANY, runOnly=["color-contrast"])
            context.close()
    assert found == []
    # The browser's console tells of the pages of errors.
    told = ("404 (NOT FOUND)", "403 (FORBIDDEN)")
    assert [error for one in errors for error in one if not error.endswith(told)] == []
    assert hosts == {urlsplit(site).netloc}
