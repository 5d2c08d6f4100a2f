"""The dashboard in a real browser: accessible, and nothing wider than 360 px."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from flask import Flask

from annotation_app.crowds.participation import Offer, sign_offer
from annotation_app.database import reading
from annotation_app.work import find_study
from tests.annotation_app.browser import Browser, engine_of, installation_of
from tests.annotation_app.dashboard.test_pages import BASE, dispute, grounding_dispute, rate
from tests.annotation_app.in_browser import CHROMIUM, FLAGS, serving

WIDTHS = (360, 1200)

playwright = pytest.importorskip("playwright.sync_api")
axe = pytest.importorskip("axe_playwright_python.sync_playwright")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed"),
]


@pytest.fixture
def address(app: Flask) -> Iterator[str]:
    with serving(app) as found:
        yield found


def preview_path(app: Flask) -> str:
    with reading(engine_of(app)) as session:
        study = find_study(session, "tests")
    key = installation_of(app).config.secret_key
    return f"/crowd/mturk/{sign_offer(key, Offer(study.id, 'rate', 5))}"


def test_pages_are_accessible_and_narrow(app: Flask, address: str, tmp_path: Path) -> None:
    judge = Browser(app, "admin")
    grounded, _ = grounding_dispute(app, judge)
    item = dispute(app)
    rate(app, {True: 1, False: 5, None: 3}, 4, 4.0)
    cookie = judge.client.get_cookie("session")
    assert cookie is not None
    paths = {
        "overview": BASE,
        "people": f"{BASE}/people",
        "queue": f"{BASE}/queue",
        "segmentations": f"{BASE}/queue/{item}",
        "groundings": f"{BASE}/queue/{grounded}",
        "preview": preview_path(app),
    }
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        problems: list[str] = []
        for width in WIDTHS:
            context = browser.new_context(viewport={"width": width, "height": 800})
            context.add_cookies([{"name": "session", "value": cookie.value, "url": address}])
            page = context.new_page()
            page.on("pageerror", lambda error: problems.append(str(error)))
            page.on("console", lambda m: problems.append(m.text) if m.type == "error" else None)
            for name, path in paths.items():
                page.goto(f"{address}{path}")
                page.screenshot(path=tmp_path / f"{name}-{width}.png", full_page=True)
                found = axe.Axe().run(page).response["violations"]
                serious = [v["id"] for v in found if v["impact"] in ("serious", "critical")]
                assert serious == [], (name, width)
                assert page.evaluate("document.documentElement.scrollWidth") <= width, name
            context.close()
        assert problems == []
        browser.close()


def test_deciding_with_the_keyboard(app: Flask, address: str) -> None:
    item = dispute(app)
    cookie = Browser(app, "adjudicator").client.get_cookie("session")
    assert cookie is not None
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        context = browser.new_context()
        context.add_cookies([{"name": "session", "value": cookie.value, "url": address}])
        page = context.new_page()
        page.goto(f"{address}{BASE}/queue/{item}")
        for _ in range(30):
            page.keyboard.press("Tab")
            if page.evaluate("document.activeElement.textContent") == "Choose answer 2":
                break
        page.keyboard.press("Enter")
        page.wait_for_url(f"**{BASE}/queue")
        assert page.get_by_role("status").inner_text() == "There is nothing to decide."
        browser.close()
