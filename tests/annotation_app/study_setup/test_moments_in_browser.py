"""Writing texts at moments of an episode in a real browser, by mouse and by keys."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, Page, expect

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import event_rows, persistent_rows
from tests.annotation_app.browser import Browser as Known
from tests.annotation_app.in_browser import (
    SERIOUS,
    errors_of,
    late,
    look,
    out_of_sight,
    schemes,
    serving,
    sign_in,
)
from tests.annotation_app.study_setup.test_moments import EVERY
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_robot_episodes import export, study_of
from tests.annotation_app.study_setup.test_subtasks_in_browser import watch

NEEDED = ("video", ".player-bar", "#kinds li:last-child button", "#undo", "#skip", "#submit")


@pytest.mark.firefox
@pytest.mark.slow
def test_somebody_writes_at_moments(context: BrowserContext, tmp_path: Path) -> None:
    tasks = {"moments": {"answers": 1, "styles": EVERY}}
    with set_up(study_of(tmp_path, tasks=tasks)) as app, serving(app) as url:
        sign_in(context, Known(app, study="robot"), url)
        page = context.new_page()
        page.emulate_media(reduced_motion="reduce")  # colours change at once
        page.set_viewport_size({"width": 1280, "height": 800})
        errors = errors_of(page)
        question = page.get_by_role("button", name="Question and answer")
        with late(page, "moments.js"):
            page.goto(f"{url}/practice/moments?study=robot", wait_until="commit")
            expect(question).to_be_disabled()
        expect(question).to_be_enabled()
        watch(page)
        page.keyboard.press("1")
        page.keyboard.type("Now to the buoy, please")
        page.get_by_role("button", name="Check my answer").click()
        expect(page.locator("#feedback")).to_contain_text("Compare yours")
        page.get_by_role("link", name="Go on").click()
        expect(page.locator("h1")).to_have_text("Moments")
        expect(page.locator(".player-bar")).to_be_visible()
        page.get_by_role("button", name="Send").click()
        expect(page.locator("#problems")).to_contain_text("Watch the video to its end first.")
        expect(page.locator("#problems")).to_contain_text("Write at least one text.")
        assert out_of_sight(page, *NEEDED) == []
        watch(page)
        assert page.locator("video").evaluate("video => video.duration") < 1.5
        _write(page)
        page.get_by_role("button", name="Send").click()
        expect(page.locator(".moment")).to_have_count(0)  # the next episode
        assert errors == []
    copy = export(tmp_path)
    events = {
        frame: [(row["role"], row["style"], row["content"]) for row in rows]
        for _, frame, rows in event_rows(open_dataset(copy))
        if frame != 1  # where the dataset has one of its own
    }
    boxes = '{"detections": [{"bbox": [16, 12, 48, 36], "bbox_format": "xyxy", "label": "cube"}]}'
    line = '{"label": "hand", "point_format": "xy", "points": [[16, 24], [32, 36]]}'
    assert events == {
        3: [("assistant", "vqa", boxes), ("user", "vqa", "Where is the 3 cube?")],
        5: [("assistant", None, None), ("user", "interjection", "Now lift it")],
        6: [("assistant", "trace", line)],
    }
    memory = [
        (round(row["timestamp"], 6), row["content"])
        for _, rows in persistent_rows(open_dataset(copy))
        for row in rows
        if row["style"] == "memory" and row["content"] != "it was near"
    ]
    assert memory == [(0.5, "I reached the cube.")]


def _write(page: Page) -> None:
    """Write four texts, two of them with drawings, and look at the page."""
    _go(page, 0.55)
    page.locator("h1").click()
    page.keyboard.press("1")
    expect(page.get_by_label("What a person says")).to_be_focused()
    page.keyboard.type("Now lift it")
    page.get_by_label("What the robot answers").fill("On it.")
    page.get_by_role("button", name="Memory").click()
    page.get_by_label("What was done so far").fill("I reached the cube.")

    _go(page, 0.35)
    page.get_by_role("button", name="Question and answer").click()
    page.get_by_label("Question", exact=True).fill("Where is the 3 cube?")  # the key types here
    page.get_by_label("How it is answered").select_option("boxes")
    expect(page.locator("#drawing-tools")).to_be_visible()
    page.get_by_role("button", name="Send").click()
    expect(page.locator("#problems")).to_contain_text("Draw in the picture at number 1.")
    _drag(page, (0.25, 0.25), (0.75, 0.75))
    page.get_by_label("Name of box 1").fill("cube")
    page.locator(".surface").focus()
    page.keyboard.press("b")
    expect(page.get_by_label("Name of box 2")).to_be_visible()
    page.keyboard.press("Delete")
    expect(page.get_by_label("Name of box 2")).to_have_count(0)
    for scheme in schemes(page):
        page.emulate_media(color_scheme=scheme)
        assert look(page, f"moments-drawing-{scheme}", SERIOUS) == []
    page.keyboard.press("Escape")  # nothing is chosen any more
    page.keyboard.press("Escape")
    expect(page.locator("#drawing-tools")).to_be_hidden()

    _go(page, 0.65)
    page.get_by_role("button", name="Path in the picture").click()
    page.keyboard.type("hand")
    _click(page, (0.25, 0.5), (0.5, 0.75))
    page.get_by_role("button", name="End the line").click()
    page.get_by_role("button", name="End drawing").last.click()
    expect(page.locator(".surface")).to_have_count(0)

    page.get_by_role("button", name="Plan").click()
    expect(page.locator(".moment")).to_have_count(5)
    page.locator(".moment", has_text="Plan").get_by_role("button", name="Remove").click()
    expect(page.locator(".moment")).to_have_count(4)
    page.get_by_role("button", name="Undo").click()
    expect(page.locator(".moment")).to_have_count(5)
    page.get_by_role("button", name="Redo").click()
    expect(page.locator(".moment")).to_have_count(4)
    expect(page.locator(".moment h3")).to_have_text(
        ["1. Question and answer", "2. Interjection", "3. Memory", "4. Path in the picture"]
    )
    page.reload()  # the draft has all of it
    expect(page.get_by_label("Name of box 1")).to_have_value("cube")
    for scheme in schemes(page):
        page.emulate_media(color_scheme=scheme)
        assert look(page, f"moments-{scheme}", SERIOUS) == []


def _go(page: Page, time_s: float) -> None:
    page.locator("video").evaluate(
        "(video, time) => new Promise(done => {"
        " video.addEventListener('seeked', done, { once: true });"
        " video.currentTime = time; })",
        time_s,
    )


def _spot(page: Page, part: tuple[float, float]) -> tuple[float, float]:
    """A place on the screen, from the part of the picture's width and height."""
    x, y = page.locator(".surface svg").first.evaluate(
        "(svg, [x, y]) => { const { width, height } = svg.viewBox.baseVal;"
        " const p = new DOMPoint(x * width, y * height).matrixTransform(svg.getScreenCTM());"
        " return [p.x, p.y]; }",
        part,
    )
    return x, y


def _drag(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    page.locator(".surface").scroll_into_view_if_needed()
    page.mouse.move(*_spot(page, start))
    page.mouse.down()
    page.mouse.move(*_spot(page, end), steps=4)
    page.mouse.up()


def _click(page: Page, *parts: tuple[float, float]) -> None:
    page.locator(".surface").scroll_into_view_if_needed()
    for part in parts:
        page.mouse.click(*_spot(page, part))
