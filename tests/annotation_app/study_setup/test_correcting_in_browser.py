"""Correcting a model's steps on the timeline in a real browser: by mouse, touch and keys."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from flask import Flask
from playwright.sync_api import Browser, BrowserContext, Locator, Page, expect

from tests.annotation_app.browser import Browser as Known
from tests.annotation_app.browser import exported
from tests.annotation_app.in_browser import (
    ANY,
    becomes,
    errors_of,
    look,
    out_of_sight,
    serving,
    sign_in,
)
from tests.annotation_app.study_setup.test_corrected_steps import fates, study_with
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_subtasks_in_browser import watch
from tests.lerobot_datasets import FPS, film

ROWS = "video,start_s,command\n" + "".join(
    f"clip00,{start},{text}\n"
    for start, text in ((0, "reach for it"), (1, "grasp"), (2, "lift it"), (3, "paint it"))
)
pytestmark = pytest.mark.slow


@contextmanager
def opened(context: BrowserContext, file: Path) -> Iterator[tuple[Flask, Page]]:
    """A person's page of the task; its console must stay silent."""
    with set_up(file) as app, serving(app) as url:
        sign_in(context, Known(app, study="robot"), url)
        page = context.new_page()
        page.emulate_media(reduced_motion="reduce")
        errors = errors_of(page)
        page.goto(f"{url}/s/robot/subtasks")
        expect(page.locator("#add")).to_be_enabled()
        yield app, page
        assert errors == []


def starts(page: Page) -> list[float]:
    inputs = page.get_by_label("Begins at, in seconds")
    return [float(inputs.nth(i).input_value()) for i in range(inputs.count())]


def starting(page: Page, expected: list[float]) -> None:
    """Wait until the steps begin there."""
    becomes(page, lambda: starts(page), expected)


def states(page: Page) -> list[str]:
    lines = page.locator(".subtask")
    return [str(lines.nth(i).get_attribute("data-state")) for i in range(lines.count())]


def middle(handle: Locator) -> tuple[float, float]:
    handle.scroll_into_view_if_needed()
    box = handle.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def second_px(page: Page) -> float:
    """How many pixels of the timeline a second has, in a film of four seconds."""
    return float(page.locator(".step-timeline .track").evaluate("track => track.clientWidth")) / 4


def go(page: Page, t: float) -> None:
    page.locator("video").evaluate(
        "(video, t) => new Promise(done => {"
        "video.addEventListener('seeked', done, {once: true}); video.currentTime = t})",
        t,
    )


@pytest.mark.firefox
def test_steps_are_corrected_by_mouse_and_keys(context: BrowserContext, tmp_path: Path) -> None:
    with opened(context, study_with(tmp_path, ROWS)) as (app, page):
        page.set_viewport_size({"width": 1280, "height": 800})
        page.locator("#instructions > summary").click()
        needed = ("video", ".player-bar", ".step-timeline", "#add", ".subtask .what", "#submit")
        assert out_of_sight(page, *needed) == []
        becomes(page, lambda: states(page), ["proposed"] * 4)
        assert look(page, "steps-proposed", ANY) == []
        watch(page)
        page.locator("h1").click()
        go(page, 0.5)
        page.keyboard.press("a")
        becomes(page, lambda: states(page), ["accepted", "proposed", "proposed", "proposed"])
        # It goes on to the next one, whose text is typed; Enter goes on.
        page.keyboard.press("e")
        second = page.get_by_label("What is done").nth(1)
        expect(second).to_be_focused()
        second.fill("grasp the handle")
        page.keyboard.press("Enter")
        expect(page.get_by_label("What is done").nth(2)).to_be_focused()
        becomes(page, lambda: states(page)[1], "changed")
        # By the mouse, on whole frames; one step of undo for all of the way.
        x, y = middle(page.get_by_role("slider", name="Beginning of step 3"))
        page.mouse.move(x, y)
        page.mouse.down()
        for part in range(1, 6):
            page.mouse.move(x + 0.1 * part * second_px(page), y)
        page.mouse.up()
        starting(page, [0, 1, 2.5, 3])
        becomes(page, lambda: states(page)[2], "changed")
        page.get_by_role("button", name="Undo").click()
        starting(page, [0, 1, 2, 3])
        page.get_by_role("button", name="Redo").click()
        starting(page, [0, 1, 2.5, 3])
        # By keys: a frame, a second, never past its neighbours.
        handle = page.get_by_role("slider", name="Beginning of step 3")
        handle.focus()
        page.keyboard.press("ArrowRight")
        becomes(page, lambda: starts(page)[2], 2.6)
        expect(handle).to_have_attribute("aria-valuenow", "2.6")
        page.keyboard.press("Shift+ArrowLeft")
        becomes(page, lambda: starts(page)[2], 1.6)
        page.keyboard.press("Home")
        becomes(page, lambda: starts(page)[2], 1.1)
        # To the frame that is shown.
        go(page, 2.25)
        page.keyboard.press("b")
        starting(page, [0, 1, 1.1, 2.2])
        page.keyboard.press("Control+z")
        page.keyboard.press("Control+z")
        starting(page, [0, 1, 1.6, 3])
        # The last one is wrong: removed, restored, removed.
        go(page, 3.5)
        page.keyboard.press("x")
        expect(page.locator("#gone")).to_contain_text("paint it")
        page.get_by_role("button", name="Restore").click()
        starting(page, [0, 1, 1.6, 3])
        page.locator(".subtask").nth(3).get_by_role("button", name="Remove").click()
        becomes(page, lambda: states(page), ["accepted", "changed", "changed"])
        # Split, and merged again.
        page.locator("h1").click()
        go(page, 2.05)
        page.keyboard.press("n")
        page.keyboard.type("turn around")
        page.locator("h1").click()
        starting(page, [0, 1, 1.6, 2])
        becomes(page, lambda: states(page)[-1], "added")
        assert look(page, "steps-corrected", ANY) == []
        page.keyboard.press("[")
        page.keyboard.press("m")
        starting(page, [0, 1, 1.6])
        page.get_by_role("button", name="Undo").click()
        page.get_by_role("button", name="Send").click()
        expect(page.locator("h1")).not_to_have_text("Subtasks")
        assert fates(app) == [
            ("reach for it", "unchanged", "True"),
            ("grasp", "text changed", "True"),
            ("lift it", "boundary moved", "True"),
            ("paint it", "removed", "True"),
            ("", "added", "True"),
        ]
        body = json.loads(exported(app, "jsonl", "robot"))["body"]
        assert [step["start_s"] for step in body["subtasks"]] == [0, 1, 1.6, 2]


def test_sending_asks_about_steps_that_are_open(context: BrowserContext, tmp_path: Path) -> None:
    with opened(context, study_with(tmp_path, ROWS)) as (app, page):
        watch(page)
        page.locator(".subtask").nth(1).get_by_role("button", name="Accept").click()
        page.get_by_role("button", name="Send").click()
        expect(page.locator("#problems")).to_contain_text("3 proposed steps: 1, 3, 4")
        page.reload()  # the draft has what was decided
        expect(page.locator(".subtask").nth(1)).to_have_attribute("data-state", "accepted")
        page.get_by_role("button", name="Send").click()
        page.get_by_role("button", name="Send it all the same").click()
        expect(page.locator("h1")).not_to_have_text("Subtasks")
        decided = [decided for _, _, decided in fates(app)]
        assert decided == ["False", "True", "False", "False"]


def test_beginnings_are_dragged_by_a_finger(chromium: Browser, tmp_path: Path) -> None:
    context = chromium.new_context(viewport={"width": 390, "height": 844}, has_touch=True)
    with opened(context, study_with(tmp_path, ROWS)) as (_, page):
        x, y = middle(page.get_by_role("slider", name="Beginning of step 2"))
        fingers = context.new_cdp_session(page)

        def touch(kind: str, *at: tuple[float, float]) -> None:
            points = [{"x": x, "y": y} for x, y in at]
            fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        # A finger needs not hit a line: it is taken along from where it was touched.
        touch("touchStart", (x + 6, y))
        for part in range(1, 9):
            touch("touchMove", (x + 6 + 0.1 * part * second_px(page), y))
        touch("touchEnd")
        starting(page, [0, 1.8, 2, 3])
        assert page.evaluate("scrollX") == 0
        # To a frame, with the player's buttons.
        go(page, 1.25)
        page.get_by_role("button", name="One frame on").click()
        page.wait_for_function("document.querySelector('video').currentTime > 1.3")
        page.get_by_role("button", name="Move a beginning here").click()
        starting(page, [0, 1.3, 2, 3])
        before = page.locator(".step-timeline .track").evaluate("track => track.clientWidth")
        page.get_by_role("button", name="Show a shorter part").click()
        page.wait_for_function(
            "twice => Math.abs(document.querySelector('.step-timeline .track').clientWidth - twice)"
            " <= 2",
            arg=2 * before,
        )
    context.close()


def test_a_listed_step_is_chosen(context: BrowserContext, tmp_path: Path) -> None:
    file = study_with(tmp_path, ROWS, vocabulary=["Reach for it", "Grasp"], subtasks=None)
    with opened(context, file) as (app, page):
        watch(page)
        options = page.locator("#known-steps option")
        listed = [options.nth(i).get_attribute("value") for i in range(options.count())]
        assert listed == ["Reach for it", "Grasp"]
        what = page.get_by_label("What is done")
        assert what.get_attribute("list") == "known-steps"
        what.fill("dance")
        page.get_by_role("button", name="Send").click()
        expect(page.locator("#problems")).to_contain_text("Choose step 1 from the list.")
        what.fill("grasp")
        page.get_by_role("button", name="Send").click()
        expect(page.locator("h1")).not_to_have_text("Subtasks")
        assert json.loads(exported(app, "jsonl", "robot"))["body"]["subtasks"][0]["text"] == "Grasp"


def test_one_of_many_steps_is_dragged(context: BrowserContext, tmp_path: Path) -> None:
    """Of a minute with 60 steps."""
    steps = 60
    film(tmp_path / "films/clip00.mp4", [20 + i % 200 for i in range(steps * FPS)])
    rows = "video,start_s,command\n" + "".join(f"clip00,{i},lift cup {i}\n" for i in range(steps))
    with opened(context, study_with(tmp_path, rows, films=0)) as (_, page):
        expect(page.locator(".boundary")).to_have_count(steps)
        x, y = middle(page.get_by_role("slider", name="Beginning of step 4", exact=True))
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 19, y, steps=5)
        page.mouse.up()
        becomes(page, lambda: 3 < starts(page)[3] < 4, True)
        assert [start for start in starts(page) if start % 1 == 0] == [0, 1, 2, *range(4, steps)]
