"""Deciding in a real browser. How its pages look is tested in `test_every_page`."""

from __future__ import annotations

import pytest
from flask import Flask
from playwright.sync_api import BrowserContext, expect

from tests.annotation_app.browser import Browser
from tests.annotation_app.dashboard.test_pages import BASE, dispute
from tests.annotation_app.in_browser import sign_in
from tests.annotation_app.signing_in import Member

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


def test_a_group_is_made_and_gets_items(app: Flask, address: str, context: BrowserContext) -> None:
    people = ("ann", "bob", "cem")
    for name in people:
        Member(app, name, "annotator")
    sign_in(context, Browser(app, "adjudicator"), address)
    page = context.new_page()
    page.goto(f"{address}{BASE}/assign")
    for name in people:
        page.get_by_label(name).check()
    page.get_by_label("Name of a group").fill("day shift")
    page.get_by_role("button", name="Save the chosen as a group").click()
    expect(page.get_by_role("status")).to_have_text("The group day shift is saved.")
    for name in people:
        page.get_by_label(name, exact=True).check()
    page.get_by_label("Name of a group").fill("night shift")
    page.keyboard.press("Enter")
    expect(page.get_by_role("status")).to_have_text("The group night shift is saved.")
    page.get_by_role("button", name="Remove the group day shift").click()
    expect(page.get_by_role("status")).to_have_text("The group day shift is removed.")
    page.get_by_label("night shift").check()
    page.get_by_label("Task").select_option("segment")
    page.get_by_role("button", name="Assign", exact=True).click()
    expect(page.get_by_role("status")).to_contain_text("of segment assigned.")
