"""Deciding in a real browser. How its pages look is tested in `test_every_page`."""

from __future__ import annotations

import pytest
from flask import Flask
from playwright.sync_api import BrowserContext

from tests.annotation_app.browser import Browser
from tests.annotation_app.dashboard.test_pages import BASE, dispute
from tests.annotation_app.in_browser import sign_in

pytestmark = pytest.mark.slow


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
