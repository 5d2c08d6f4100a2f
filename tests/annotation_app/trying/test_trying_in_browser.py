"""A command typed in a real browser, followed by a real model in real physics, and filmed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from flask import Flask
from playwright.sync_api import BrowserContext, Route, expect

from annotation_app.serving.factory import create_app
from annotation_app.trying.attempt_queue import attempts
from tests.annotation_app.browser import engine_of, installation_of
from tests.annotation_app.in_browser import (
    drawn_anew,
    errors_of,
    late,
    serving,
    violations,
    width_of,
)

pytestmark = pytest.mark.slow

PATIENCE_MS = 180_000
COVERED = """() => ["#picture", "#map"].flatMap(where => {
  const boxes = of => [...document.querySelectorAll(`${where} ${of}`)].map(
    one => one.getBoundingClientRect());
  const share = (a, b) =>
    Math.max(0, Math.min(a.right, b.right) - Math.max(a.left, b.left)) *
    Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top)) / (b.width * b.height);
  const caps = boxes(".cap:not(.left-out) rect"), places = boxes(".place-shape");
  return caps.flatMap((cap, i) => [
    ...caps.slice(i + 1).map(other => share(cap, other)).filter(part => part > 0.02),
    ...places.map(place => share(cap, place)).filter(part => part > 0.5),
  ].map(part => `${where}: ${part}`));
})"""
"""Shares of labels, and of places, that a label hides."""


@pytest.fixture(scope="module")
def model(trained: Callable[[str], Path]) -> Path:
    """A small model."""
    return trained("one-scenario")


@pytest.fixture
def address(app: Flask, model: Path) -> Iterator[str]:
    config = replace(installation_of(app).config, open_trying=True, model=model)
    open_app = create_app(config, engine_of(app))
    with serving(open_app) as found:
        yield found
    with open_app.app_context():
        attempts().close()


def test_a_command_is_followed_and_filmed(address: str, context: BrowserContext) -> None:
    page = context.new_page()
    errors = errors_of(page)
    page.emulate_media(reduced_motion="reduce")  # colours on their way have little contrast
    with late(page, "try.js"):
        page.goto(f"{address}/try", wait_until="commit")
        page.get_by_label("What is the robot").fill("fly")
        page.keyboard.press("Enter")
        expect(page.locator("#go")).to_be_disabled()
    on_map = page.locator("#map .cap:not(.left-out)")
    expect(on_map.filter(has_text="forklift")).to_be_visible()
    picture = page.locator("#picture img")
    expect(picture).not_to_have_js_property("naturalWidth", 0, timeout=PATIENCE_MS)
    expect(page.locator("#picture .cap:not(.left-out)").first).to_be_visible()
    page.get_by_role("button", name="Try it").click()
    expect(page.get_by_text("Nothing: ")).to_be_visible(timeout=PATIENCE_MS)
    expect(page.locator("#go")).to_be_enabled()
    page.get_by_label("What is the robot").fill("Lift the elephant")
    page.get_by_role("button", name="Try it").click()
    expect(page.get_by_text("I see no elephant here. There are: ").first).to_be_visible(
        timeout=PATIENCE_MS
    )
    expect(page.get_by_role("button", name="Do it with what there is")).to_be_visible()
    expect(page.locator("#go")).to_be_enabled()
    page.get_by_label("World").select_option("dock_pick_up_tires")
    expect(picture).to_have_attribute("src", "/try/scenes/dock_pick_up_tires", timeout=PATIENCE_MS)
    page.get_by_label("What is the robot").fill('Pick up the boxes <img src=x onerror="throw 1">')
    page.keyboard.press("Enter")
    expect(page.locator("#phase")).not_to_be_empty()
    video = page.get_by_label("The robot carries the plan out")
    expect(video).to_be_visible(timeout=PATIENCE_MS)
    assert (
        video.evaluate(
            "v => new Promise(done => v.readyState > 1 ? done(v.videoWidth) : "
            "v.addEventListener('loadeddata', () => done(v.videoWidth)))"
        )
        == 640
    )
    expect(page.get_by_role("listitem").filter(has_text="pick up").first).to_be_visible()
    clause = page.locator("[data-node]").first
    clause.press("Enter")
    expect(clause).to_have_attribute("aria-pressed", "true")
    expect(clause).to_be_focused()
    for where in ("#picture", "#map"):
        expect(page.locator(f"{where} .chosen .shape").first).to_be_visible()
        expect(page.locator(f"{where} .labels .chosen text").first).to_contain_text("%")
    expect(page.get_by_alt_text("Among them")).not_to_have_js_property("naturalWidth", 0)
    impacts = ("moderate", "serious", "critical")
    found = violations(page, impacts)
    page.emulate_media(color_scheme="dark")
    found += violations(page, impacts)
    page.set_viewport_size({"width": 360, "height": 740})
    assert width_of(page) <= 360
    assert found == []
    assert errors == []


def test_labels_hide_nothing_on_a_telephone(address: str, context: BrowserContext) -> None:
    page = context.new_page()
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto(f"{address}/try")
    expect(page.locator("#picture img")).not_to_have_js_property(
        "naturalWidth", 0, timeout=PATIENCE_MS
    )
    command = "Put the box pallet down beside the barrel, then go to the charging station"
    page.get_by_label("What is the robot").fill(command)
    page.keyboard.press("Enter")
    clauses = page.locator("[data-node]")
    expect(clauses.first).to_be_visible(timeout=PATIENCE_MS)
    for clause in clauses.all():
        clause.click()
        number = page.locator("#key .chosen b").first.inner_text().split(", ")[0]
        chosen = page.locator("#map .labels .chosen text")
        expect(chosen.filter(has_text=number).first).to_be_visible()
        drawn_anew(page)
        assert page.evaluate(COVERED) == []
    page.set_viewport_size({"width": 1280, "height": 800})
    expect(page.locator("#key")).to_be_hidden()
    expect(page.locator("#map .labels .chosen text").first).to_contain_text("%")


def test_the_next_command_waits_for_no_video(address: str, context: BrowserContext) -> None:
    page = context.new_page()
    page.goto(f"{address}/try")
    page.get_by_label("World").select_option("dock_pick_up_tires")
    steps = page.locator("#found ol li")
    for load in ("boxes", "tires") * 4:
        page.get_by_label("What is the robot").fill(f"Pick up the {load}")
        page.keyboard.press("Enter")
        expect(steps.filter(has_text=f"{load}-")).to_be_visible(timeout=PATIENCE_MS)
    expect(page.get_by_label("The robot carries the plan out")).to_be_visible(timeout=PATIENCE_MS)


def test_a_world_that_cannot_be_shown_is_told_of_once(
    address: str, context: BrowserContext
) -> None:
    page = context.new_page()
    asked: list[str] = []

    def fail(route: Route) -> None:
        asked.append(route.request.url)
        route.fulfill(status=503 if len(asked) == 1 else 500, json={})

    page.route("**/api/try/scenes/*", fail)
    page.goto(f"{address}/try")
    expect(page.locator("#problem")).to_contain_text("went wrong on the server")
    page.wait_for_timeout(1000)
    assert len(asked) == 2
