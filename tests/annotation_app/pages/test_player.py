"""The video player: what it does, what it covers, and what it counts."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import BrowserContext, FloatRect, Locator, Page, expect

from tests.annotation_app.pages.conftest import Site
from tests.annotation_app.pages.films import FPS, SECONDS
from tests.annotation_app.pages.test_tasks import send, watch

pytestmark = pytest.mark.slow

WATCHED = ("describe", "ground", "check", "rate")
FRAME_S = 1 / FPS


def box_of(element: Locator) -> FloatRect:
    box = element.bounding_box()
    assert box is not None
    return box


def time_of(page: Page) -> float:
    return float(page.locator("video").first.evaluate("video => video.currentTime"))


def frame_of(page: Page) -> int:
    return int(time_of(page) / FRAME_S + 1e-6)


def ready(page: Page) -> Page:
    """A page whose video has come."""
    expect(page.locator("video").first).to_have_js_property("readyState", 4)
    return page


def test_the_bar_covers_nothing_and_play_is_above_the_fold(
    site: Site, context: BrowserContext
) -> None:
    site.sign_in(context)
    page = context.new_page()
    page.set_viewport_size({"width": 1280, "height": 800})
    for path in (f"{folder}/{task}" for task in WATCHED for folder in ("/s/sea", "/practice")):
        page.goto(site.url + path)
        ready(page)
        video = page.locator("video").first
        assert video.evaluate("video => video.controls") is False
        picture, bar = box_of(video), box_of(page.locator(".player-bar").first)
        assert bar["y"] >= picture["y"] + picture["height"] - 1, path
        if path.endswith(("describe", "rate")):
            play, sending = box_of(page.locator(".play")), box_of(page.locator(".send"))
            assert picture["height"] >= 200
            assert play["y"] + play["height"] <= min(sending["y"], 800), path
            assert page.evaluate("scrollY") == 0


def test_frames_one_by_one(site: Site, context: BrowserContext) -> None:
    page = ready(site.open(context, "rate"))
    page.get_by_role("button", name="One frame on").click()
    assert frame_of(page) == 1
    page.keyboard.press(".")
    page.keyboard.press(".")
    assert frame_of(page) == 3
    page.keyboard.press(",")
    assert frame_of(page) == 2
    for _ in range(FPS):
        page.keyboard.press(".")
    assert frame_of(page) >= FPS * SECONDS - 1  # browsers go on to the end from the last frame
    page.keyboard.press(",")
    assert frame_of(page) == FPS * SECONDS - 2
    page.get_by_role("button", name="To the start").click()
    assert time_of(page) == 0
    page.keyboard.press(",")
    assert time_of(page) == 0


def test_the_rate_of_frames_is_measured_where_nobody_tells_it(
    site: Site, context: BrowserContext
) -> None:
    site.sign_in(context)
    page = context.new_page()
    page.add_init_script(
        "const forget = () => document.querySelectorAll('[data-fps]').forEach("
        "box => box.removeAttribute('data-fps'));"
        "new MutationObserver(forget).observe(document, {childList: true, subtree: true})"
    )
    page.goto(f"{site.url}/s/sea/rate")
    watch(page)
    page.get_by_role("button", name="To the start").click()
    for _ in range(3):
        page.keyboard.press(".")
    assert frame_of(page) == 3


def test_seeking(site: Site, context: BrowserContext) -> None:
    page = ready(site.open(context, "rate"))
    slider = page.get_by_label("Time in the video")
    slider.focus()
    slider.press("End")
    assert time_of(page) == pytest.approx(SECONDS, abs=FRAME_S)
    slider.press("Home")
    slider.press("ArrowRight")
    assert time_of(page) == pytest.approx(FRAME_S)
    expect(page.locator(".clock")).to_have_text("0.1 / 1.0 s")


def test_speed_is_remembered_and_watching_counts_in_seconds_of_the_video(
    site: Site, context: BrowserContext
) -> None:
    page = ready(site.open(context, "rate"))
    page.get_by_label("Speed").select_option("2×")
    page.keyboard.press("Escape")
    page.locator("#likert legend").click()
    page.keyboard.press(">")
    page.keyboard.press(">")
    page.keyboard.press(">")
    expect(page.get_by_label("Speed")).to_have_value("4")
    page.reload()
    ready(page)
    expect(page.get_by_label("Speed")).to_have_value("4")
    assert page.locator("video").evaluate("video => video.playbackRate") == 4
    page.keyboard.press("k")
    expect(page.get_by_text("You have watched it to the end")).to_be_visible()
    page.get_by_label("Disagree", exact=False).nth(1).check()
    send(page, "rate")
    (answer,) = site.answers("rate")
    assert answer.body["watched_s"] == pytest.approx(SECONDS, abs=0.1)
    assert answer.body["speed"] == 4


def test_play_and_pause_by_keys(site: Site, context: BrowserContext) -> None:
    page = ready(site.open(context, "describe"))
    page.get_by_label("Speed").select_option("0.5×")
    page.locator("h1").click()
    page.keyboard.press("k")
    expect(page.locator(".play")).to_have_text("Pause")
    page.keyboard.press("k")
    expect(page.locator(".play")).to_have_text("Play")
    page.locator("#text").press_sequentially("k, .")
    expect(page.locator(".play")).to_have_text("Play")
    page.locator("video").click()
    expect(page.locator(".play")).to_have_text("Pause")


def test_the_whole_screen(site: Site, context: BrowserContext) -> None:
    page = ready(site.open(context, "rate"))
    page.get_by_role("button", name="Full screen").click()
    expect(page.locator(".player:fullscreen")).to_be_visible()
    picture, bar = box_of(page.locator("video")), box_of(page.locator(".player-bar"))
    assert bar["y"] >= picture["y"] + picture["height"] - 1
    page.get_by_role("button", name="Full screen").click()
    expect(page.locator(".player:fullscreen")).to_have_count(0)


def test_a_video_that_cannot_be_played_says_so(site: Site, context: BrowserContext) -> None:
    context.route("**/media/*", lambda route: route.abort())
    page = site.open(context, "rate")
    expect(page.get_by_role("button", name="Try again")).to_be_visible()


def test_segment_has_the_video_at_hand(site: Site, context: BrowserContext) -> None:
    page = site.open(context, "segment")
    page.get_by_text("The video, if the words alone").click()
    page.locator(".play").click()
    expect(page.locator(".play")).to_have_text("Play")
    expect(page.locator(".player-bar .clock")).to_have_text(re.compile(r"^([1-9][\d.]*) / \1 s$"))
