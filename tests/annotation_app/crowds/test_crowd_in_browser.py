"""A Mechanical Turk worker in a real browser, from the preview to the platform's form."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlencode, urlsplit

import pytest
from flask import Flask

from annotation_app.config import Config
from annotation_app.crowds.mturk import NOT_AVAILABLE, SITES
from annotation_app.database import open_database
from annotation_app.factory import create_app
from tests.annotation_app.browser import described
from tests.annotation_app.crowds.crowd_worker import CrowdWorker, Lab, external_url
from tests.annotation_app.crowds.stand_ins import MechanicalTurk
from tests.annotation_app.in_browser import CHROMIUM, FLAGS, serving

playwright = pytest.importorskip("playwright.sync_api")
axe = pytest.importorskip("axe_playwright_python.sync_playwright")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"),
]


@pytest.fixture
def framed(app: Flask, config: Config) -> Iterator[Flask]:
    """The app as it is set up for the platform."""
    engine = open_database(config.database)
    yield create_app(replace(config, form_targets=SITES), engine)
    engine.dispose()


@pytest.fixture
def address(framed: Flask) -> Iterator[str]:
    with serving(framed) as found:
        yield found


def test_from_the_preview_to_the_platform(
    framed: Flask, config: Config, address: str, mturk: MechanicalTurk, tmp_path: Path
) -> None:
    lab = Lab(config, mturk.address)
    assert lab.publish("--task", "describe", "--items", "1", "--people", "1").exit_code == 0
    (hit,) = mturk.hits.values()
    url = address + urlsplit(external_url(hit["Question"])).path
    arguments = mturk.accept("W1")

    def take(route: Any) -> None:
        status, _ = mturk.external_submit(parse_qs(route.request.post_data))
        route.fulfill(status=status, content_type="text/html", body="<h1>Thanks</h1>")

    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        context = browser.new_context(viewport={"width": 360, "height": 800})
        context.route("https://workersandbox.mturk.com/**", take)
        page = context.new_page()
        page.goto(f"{url}?assignmentId={NOT_AVAILABLE}")
        assert page.get_by_role("status").inner_text().startswith("This is a preview.")
        assert context.cookies() == []
        page.screenshot(path=tmp_path / "preview.png")

        # The work itself is done by the interface; the pages have tests of their own.
        worker = CrowdWorker(framed, url, arguments)
        worker.do("describe", described())
        page.goto(f"{url}?{urlencode(arguments)}")
        page.wait_for_url("**/crowd/finish")
        page.screenshot(path=tmp_path / "finish.png")
        found = axe.Axe().run(page).response["violations"]
        assert [v["id"] for v in found if v["impact"] in ("serious", "critical")] == []
        assert page.evaluate("document.documentElement.scrollWidth") <= 360
        page.keyboard.press("Tab")
        page.keyboard.press("Enter")
        page.get_by_role("heading", name="Thanks").wait_for()
        browser.close()
    assert mturk.status(arguments["assignmentId"]) == "Submitted"
    assert lab.collect().exit_code == 0
    assert mturk.status(arguments["assignmentId"]) == "Approved"
