"""Cutting an episode into steps in a real browser."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, expect

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import persistent_rows
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
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_robot_episodes import export, study_of

NEEDED = ("video", ".player-bar", ".subtask .what", "#add", "#undo", "#skip", "#submit")


@pytest.mark.firefox
@pytest.mark.slow
def test_somebody_cuts_an_episode(context: BrowserContext, tmp_path: Path) -> None:
    tasks = {"subtasks": {"answers": 1}}
    file = study_of(tmp_path, tasks=tasks, commands=None)
    file.write_text(json.dumps({k: v for k, v in json.loads(file.read_text()).items() if v}))
    with set_up(file) as app, serving(app) as url:
        sign_in(context, Known(app, study="robot"), url)
        page = context.new_page()
        page.emulate_media(reduced_motion="reduce")  # colours change at once
        errors = errors_of(page)
        add = page.get_by_role("button", name="A step begins here")
        with late(page, "subtasks.js"):
            page.goto(f"{url}/practice/subtasks?study=robot", wait_until="commit")
            expect(add).to_be_disabled()
        expect(add).to_be_enabled()
        watch(page)
        page.get_by_label("What is done").fill("Sail to the buoy")
        page.get_by_role("button", name="Check my answer").click()
        expect(page.locator("#feedback")).to_contain_text("Compare yours")
        page.get_by_role("link", name="Go on").click()
        expect(page.locator("h1")).to_have_text("Subtasks")
        expect(page.locator(".player-bar")).to_be_visible()
        page.get_by_role("button", name="Send").click()
        expect(page.locator("#problems")).to_contain_text("Watch the video to its end first.")
        expect(page.locator("#problems")).to_contain_text("Say what is done in step 1.")
        page.set_viewport_size({"width": 1280, "height": 800})
        assert out_of_sight(page, *NEEDED) == []
        watch(page)
        duration = page.locator("video").evaluate("video => video.duration")
        assert duration < 1.5  # the episode alone, not the file with all of them
        page.get_by_label("What is done").fill("reach for the cube")
        page.locator("video").evaluate("video => { video.currentTime = 0.5 }")
        page.locator("h1").click()
        page.keyboard.press("n")
        second = page.get_by_label("What is done").nth(1)
        expect(second).to_be_focused()
        second.fill("grasp n it")  # the key types a letter here
        add.click()  # one begins with this frame already
        expect(second).to_be_focused()
        page.keyboard.press("Escape")
        page.locator("video").evaluate("video => { video.currentTime = 0.8 }")
        add.click()
        expect(page.locator(".subtask")).to_have_count(3)
        page.locator(".subtask").last.get_by_role("button", name="Remove").click()
        expect(page.locator(".subtask")).to_have_count(2)
        page.get_by_role("button", name="Undo").click()
        expect(page.locator(".subtask")).to_have_count(3)
        second.focus()
        page.get_by_label("What is done").last.focus()
        page.evaluate("scrollTo(0, 0)")
        assert out_of_sight(page, *NEEDED, ".subtask:last-child .what") == []
        page.get_by_role("button", name="Redo").click()
        for scheme in schemes(page):
            page.emulate_media(color_scheme=scheme)
            assert look(page, f"subtasks-{scheme}", SERIOUS) == []
        page.get_by_role("button", name="Send").click()
        expect(page.locator(".subtask")).to_have_count(1)
        expect(page.get_by_label("What is done")).to_have_value("")  # the next episode
        assert errors == []
    found = [rows for _, rows in persistent_rows(open_dataset(export(tmp_path)))]
    steps = [
        (row["timestamp"], row["content"])
        for rows in found
        for row in rows
        if row["style"] == "subtask" and row["content"] not in ("reach", "grasp", "push")
    ]
    assert steps == [(0.0, "reach for the cube"), (0.5, "grasp n it")]


def watch(page) -> None:
    page.locator("video").evaluate("video => { video.currentTime = 0; return video.play() }")
    expect(page.get_by_text("You have watched it to the end.")).to_be_visible(timeout=20_000)
