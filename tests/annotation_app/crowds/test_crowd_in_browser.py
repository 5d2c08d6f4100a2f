"""A Mechanical Turk worker in a real browser, from the preview to the platform's form."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any
from urllib.parse import parse_qs, urlencode, urlsplit

import pytest
from flask import Flask
from playwright.sync_api import BrowserContext

from annotation_app.core.config import Config
from annotation_app.crowds.mturk import NOT_AVAILABLE, SITES
from annotation_app.serving.factory import create_app
from annotation_app.store.database import open_database
from tests.annotation_app.browser import described
from tests.annotation_app.crowds.crowd_worker import CrowdWorker, Lab, external_url
from tests.annotation_app.crowds.stand_ins import MechanicalTurk
from tests.annotation_app.in_browser import (
    serving,
    violations,
    width_of,
)

pytestmark = pytest.mark.slow


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
    framed: Flask, config: Config, address: str, mturk: MechanicalTurk, context: BrowserContext
) -> None:
    lab = Lab(config, mturk.address)
    assert lab.publish("--task", "describe", "--items", "1", "--people", "1").exit_code == 0
    (hit,) = mturk.hits.values()
    url = address + urlsplit(external_url(hit["Question"])).path
    arguments = mturk.accept("W1")

    def take(route: Any) -> None:
        status, _ = mturk.external_submit(parse_qs(route.request.post_data))
        route.fulfill(status=status, content_type="text/html", body="<h1>Thanks</h1>")

    context.route("https://workersandbox.mturk.com/**", take)
    page = context.new_page()
    page.set_viewport_size({"width": 360, "height": 800})
    page.goto(f"{url}?assignmentId={NOT_AVAILABLE}")
    assert page.get_by_role("status").inner_text().startswith("This is a preview.")
    assert context.cookies() == []

    # The work itself is done by the interface; the pages have tests of their own.
    worker = CrowdWorker(framed, url, arguments)
    worker.do("describe", described())
    page.goto(f"{url}?{urlencode(arguments)}")
    page.wait_for_url("**/crowd/finish")
    assert violations(page) == []
    assert width_of(page) <= 360
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="Thanks").wait_for()
    assert mturk.status(arguments["assignmentId"]) == "Submitted"
    assert lab.collect().exit_code == 0
    assert mturk.status(arguments["assignmentId"]) == "Approved"
