"""The dashboard in a real browser: accessible, and nothing wider than 360 px."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from flask import Flask
from playwright.sync_api import BrowserContext

from annotation_app.crowds.participation import Offer, sign_offer
from annotation_app.store.database import reading
from annotation_app.work.handing_out import find_study
from tests.annotation_app.browser import Browser, engine_of, installation_of
from tests.annotation_app.dashboard.test_pages import BASE, dispute, grounding_dispute, rate
from tests.annotation_app.in_browser import (
    errors_of,
    serving,
    violations,
    width_of,
)

WIDTHS = (360, 1200)

pytestmark = pytest.mark.slow


@pytest.fixture
def address(app: Flask) -> Iterator[str]:
    with serving(app) as found:
        yield found


def preview_path(app: Flask) -> str:
    with reading(engine_of(app)) as session:
        study = find_study(session, "tests")
    key = installation_of(app).config.secret_key
    return f"/crowd/mturk/{sign_offer(key, Offer(study.id, 'rate', 5))}"


def sign_in(context: BrowserContext, person: Browser, address: str) -> None:
    cookie = person.client.get_cookie("session")
    assert cookie is not None
    context.add_cookies([{"name": "session", "value": cookie.value, "url": address}])


def test_pages_are_accessible_and_narrow(app: Flask, address: str, context: BrowserContext) -> None:
    judge = Browser(app, "admin")
    grounded, _ = grounding_dispute(app, judge)
    item = dispute(app)
    rate(app, {True: 1, False: 5, None: 3}, 4, 4.0)
    paths = (
        BASE,
        f"{BASE}/people",
        f"{BASE}/queue",
        f"{BASE}/queue/{item}",
        f"{BASE}/queue/{grounded}",
        preview_path(app),
    )
    sign_in(context, judge, address)
    page = context.new_page()
    errors = errors_of(page)
    found: list[str] = []
    for path in paths:
        page.goto(f"{address}{path}")
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 800})
            found += violations(page)
            assert width_of(page) <= width, path
    assert found == []
    assert errors == []


def test_deciding_with_the_keyboard(app: Flask, address: str, context: BrowserContext) -> None:
    item = dispute(app)
    sign_in(context, Browser(app, "adjudicator"), address)
    page = context.new_page()
    page.goto(f"{address}{BASE}/queue/{item}")
    for _ in range(30):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.textContent") == "Choose answer 2":
            break
    page.keyboard.press("Enter")
    page.wait_for_url(f"**{BASE}/queue")
    assert page.get_by_role("status").inner_text() == "There is nothing to decide."
