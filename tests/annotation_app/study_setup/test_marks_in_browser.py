"""Marking episodes and correcting their tasks in a real browser, by keys alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import BrowserContext, Page, expect

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

import pyarrow.parquet as pq

from corpus_tools.lerobot.episode_reading import open_dataset
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
from tests.annotation_app.signing_in import signed_in
from tests.annotation_app.study_setup.test_marks_and_corrections import (
    INDEX,
    PEOPLE,
    answer_all,
    study,
)
from tests.annotation_app.study_setup.test_own_videos import set_up
from tests.annotation_app.study_setup.test_robot_episodes import export
from tests.annotation_app.study_setup.test_subtasks_in_browser import watch

pytestmark = [pytest.mark.slow, pytest.mark.firefox]

MARK = ("video", ".player-bar", "#success", "#quality", "#reasons", "#moment", "#submit")
CORRECT = ("#command", "video", ".player-bar", "#verdict", "#submit")


def settings(task: str, **of_task: Any) -> dict[str, Any]:
    return {"tasks": {task: {"answers": 1, **of_task}}}


def opened(context: BrowserContext, url: str, task: str) -> Page:
    """The practice page of a task, whose script comes late."""
    page = context.new_page()
    page.emulate_media(reduced_motion="reduce")
    page.set_viewport_size({"width": 1280, "height": 800})
    with late(page, f"{task}.js"):
        page.goto(f"{url}/practice/{task}?study=robot", wait_until="commit")
        expect(page.locator("#submit")).to_be_disabled()
    expect(page.locator("#submit")).to_be_enabled()
    return page


def looked_at(page: Page, name: str) -> None:
    for scheme in schemes(page):
        page.emulate_media(color_scheme=scheme)
        assert look(page, f"{name}-{scheme}", SERIOUS) == []


def test_somebody_marks_an_episode_by_keys(context: BrowserContext, tmp_path: Path) -> None:
    file = study(tmp_path, {"commands": None, **settings("mark")})
    with set_up(file) as app, serving(app) as url:
        sign_in(context, Known(app, study="robot"), url)
        page = opened(context, url, "mark")
        errors = errors_of(page)
        watch(page)
        page.locator("h1").click()
        page.keyboard.press("f")
        page.keyboard.press("1")
        page.keyboard.press("a")
        page.get_by_role("button", name="Check my answer").click()
        expect(page.locator("#feedback")).to_contain_text("Watch again")
        page.keyboard.press("s")
        page.keyboard.press("5")
        page.get_by_role("button", name="Check my answer").click()
        expect(page.locator("#feedback")).to_contain_text("Well done")
        page.get_by_role("link", name="Go on").click()
        expect(page.locator("#feedback")).to_be_hidden()
        expect(page.locator("#submit")).to_be_enabled()
        page.keyboard.press("Control+Enter")
        for told in ("Watch the video to its end", "did its task", "how well"):
            expect(page.locator("#problems")).to_contain_text(told)
        assert out_of_sight(page, *MARK) == []
        watch(page)
        page.locator("video").evaluate("video => { video.currentTime = 0.55 }")
        page.keyboard.press("p")
        page.keyboard.press("2")
        page.keyboard.press("m")
        expect(page.get_by_role("button", name="Show 0.5 s")).to_be_visible()
        page.keyboard.press("Control+Enter")
        expect(page.locator("#problems")).to_contain_text("If no reason fits, write a note")
        page.keyboard.press("d")
        page.keyboard.press("b")
        page.keyboard.press("d")
        expect(page.get_by_role("checkbox", name="The wrong thing")).to_be_checked()
        expect(page.get_by_role("checkbox", name="The robot hits")).not_to_be_checked()
        page.keyboard.press("Control+z")
        expect(page.get_by_role("checkbox", name="The robot hits")).to_be_checked()
        page.keyboard.press("Control+y")
        page.get_by_label("Note").fill("a sloppy grasp")  # the letters choose nothing here
        expect(page.get_by_role("radio", name="Partly")).to_be_checked()
        looked_at(page, "mark")
        assert len(page.locator("blockquote.command").all_inner_texts()) <= 1
        duration = page.locator("video").evaluate("video => video.duration")
        page.keyboard.press("Control+Enter")
        expect(page.get_by_label("Note")).to_have_value("")  # the next episode
        assert errors == []
    number = {1.2: 0, 0.8: 1, 1.0: 2}[round(duration, 1)]
    row = pq.read_table(export(tmp_path) / INDEX).to_pylist()[number]
    assert (row["marks/success"], row["marks/quality"], row["marks/moment_s"]) == ("partly", 2, 0.5)
    assert row["marks/reasons"] == ["The wrong thing is handled"]


def test_somebody_corrects_a_task_by_keys(context: BrowserContext, tmp_path: Path) -> None:
    with set_up(study(tmp_path, settings("correct"))) as app, serving(app) as url:
        sign_in(context, Known(app, study="robot"), url)
        page = opened(context, url, "correct")
        errors = errors_of(page)
        watch(page)
        page.locator("h1").click()
        for key, told in (("u", "Watch again"), ("r", "Well done")):
            page.keyboard.press(key)
            page.get_by_role("button", name="Check my answer").click()
            expect(page.locator("#feedback")).to_contain_text(told)
        page.get_by_role("link", name="Go on").click()
        expect(page.locator("#command")).to_have_text("Push the cube.")
        assert out_of_sight(page, *CORRECT) == []
        watch(page)
        text = page.get_by_label("What should the task be?")
        expect(text).to_be_hidden()
        page.locator("h1").click()
        page.keyboard.press("w")
        expect(text).to_be_focused()
        expect(text).to_have_value("Push the cube.")  # often one word is wrong
        page.keyboard.press("Control+Enter")
        expect(page.locator("#problems")).to_contain_text("This is the same task")
        text.fill("Lift the cube.")
        assert out_of_sight(page, *CORRECT, "#text") == []
        looked_at(page, "correct")
        duration = page.locator("video").evaluate("video => video.duration")
        page.keyboard.press("Control+Enter")
        expect(page.get_by_role("radio", name="Wrong")).not_to_be_checked()  # the next episode
        assert errors == []
    tasks = [episode.tasks for episode in open_dataset(export(tmp_path)).episodes()]
    assert tasks[0 if duration > 1.1 else 1] == ("Lift the cube.",)
    assert ("Push the cube.",) in tasks


def test_the_dashboard_shows_marks(context: BrowserContext, tmp_path: Path) -> None:
    more = {"answers": 3, "practice": False}
    reasons = ["Something falls", "It hits something"]
    file = study(tmp_path, {"commands": None, "reasons": reasons, **settings("mark", **more)})
    with set_up(file) as app, serving(app) as url:
        answer_all(app, "mark", *PEOPLE)
        sign_in(context, signed_in(app, "ada", "admin"), url)
        page = context.new_page()
        page.emulate_media(reduced_motion="reduce")
        errors = errors_of(page)
        page.goto(f"{url}/dashboard/robot")
        page.get_by_text("All numbers as tables").click()
        expect(page.get_by_label("Reasons against episodes")).to_contain_text("Something falls")
        expect(page.get_by_label("Marks of success")).to_contain_text("success")
        looked_at(page, "marks-dashboard")
        page.goto(f"{url}/dashboard/robot/queue/next")
        expect(page.locator("h2", has_text="Answer 1")).to_be_visible()
        looked_at(page, "marks-dispute")
        page.get_by_text("The video", exact=True).click()
        expect(page.locator(".film .curves")).to_be_visible()
        looked_at(page, "marks-dispute-video")
        page.get_by_role("link", name="Edit answer 1").click()
        expect(page.locator("#submit")).to_be_enabled()
        expect(page.locator("input[name=success]:checked")).to_have_count(1)
        looked_at(page, "marks-adjudicated")
        page.get_by_role("button", name="Adopt this answer").click()
        page.wait_for_url("**/queue/**")
        assert errors == []
