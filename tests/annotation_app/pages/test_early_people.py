"""What people do before a page's script has come counts, or can't be done yet."""

from __future__ import annotations

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.annotation_app.in_browser import errors_of, late
from tests.annotation_app.pages.conftest import Site
from tests.annotation_app.pages.test_tasks import send, watch

pytestmark = pytest.mark.slow

SLOWEST = 0.0625
"""The slowest speed that browsers play at: a second takes 16."""


@pytest.fixture
def page(site: Site, context: BrowserContext) -> Page:
    site.sign_in(context)
    return context.new_page()


def come(page: Page, site: Site, task: str) -> None:
    page.goto(f"{site.url}/s/sea/{task}", wait_until="commit")


def play(page: Page, speed: float) -> None:
    """As with the browser's own controls."""
    page.locator("video").evaluate(
        "(video, speed) => { video.playbackRate = speed; return video.play(); }", speed
    )


def test_a_video_is_watched_and_a_command_typed(site: Site, page: Page) -> None:
    errors = errors_of(page)
    with late(page, "describe.js"):
        come(page, site, "describe")
        play(page, 0.5)
        expect(page.locator("video")).to_have_js_property("ended", True)
        page.locator("#text").fill("Go to the red crate.")
        expect(page.locator("#submit")).to_be_disabled()
    expect(page.get_by_text("You have watched it to the end")).to_be_visible()
    expect(page.locator("#text")).to_have_value("Go to the red crate.")
    expect(page.locator(".play")).to_have_text("Play")
    send(page, "describe")
    (answer,) = site.answers("describe")
    assert answer.body["text"] == "Go to the red crate."
    assert answer.body["watched_s"] >= 0.9
    assert answer.body["speed"] == 0.5
    assert errors == []


def test_a_video_goes_on_at_its_speed(site: Site, page: Page) -> None:
    # Whoever plays the video is at work on the item.
    with page.expect_response("**/begin"), late(page, "describe.js"):
        come(page, site, "describe")
        play(page, SLOWEST)
    expect(page.locator(".play")).to_have_text("Pause")
    expect(page.locator("video")).to_have_js_property("playbackRate", SLOWEST)
    page.locator(".play").click()
    page.get_by_label("Speed").select_option("4×")
    page.locator(".play").click()
    watch(page)
    page.locator("#text").fill("Go.")
    send(page, "describe")
    assert [answer.body["speed"] for answer in site.answers("describe")] == [4]


def test_what_is_typed_comes_after_the_draft(site: Site, page: Page) -> None:
    page.goto(f"{site.url}/s/sea/describe")
    text = page.locator("#text")
    text.fill("Go to")
    expect(page.locator("#saving")).to_have_text("Saved")
    with late(page, "describe.js"):
        page.reload(wait_until="commit")
        expect(text).to_have_value("")
        text.fill("the red crate.")
    expect(text).to_have_value("Go to the red crate.")
    page.reload()
    expect(text).to_have_value("Go to the red crate.")  # once, whatever browsers put back
    page.goto(f"{site.url}/s/sea")
    page.go_back()
    expect(text).to_have_value("Go to the red crate.")


def test_nothing_is_rated(site: Site, page: Page) -> None:
    agree = page.get_by_role("radio").nth(3)
    with late(page, "rate.js"):
        come(page, site, "rate")
        expect(agree).to_be_disabled()
    agree.check()
    watch(page)
    send(page, "rate")
    assert [answer.body["rating"] for answer in site.answers("rate")] == [4]


def test_keys_are_not_chosen(site: Site, page: Page) -> None:
    keys = page.locator("#single-keys")
    with late(page, "check.js"):
        come(page, site, "check")
        expect(keys).to_be_disabled()
    expect(keys).to_be_enabled()
