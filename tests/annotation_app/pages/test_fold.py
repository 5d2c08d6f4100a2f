"""Nothing that people need on a page is below the fold."""

from __future__ import annotations

from functools import partial

import pytest
from playwright.sync_api import BrowserContext, expect

from annotation_app.tasks.task_registry import task_names
from tests.annotation_app.in_browser import becomes, drawn_anew, out_of_sight
from tests.annotation_app.pages.conftest import TASKS, Site

pytestmark = pytest.mark.slow

SMALLEST_PICTURE = 250
NEEDED = {
    "describe": ("video", ".player-bar", "#text", "#counter", "#submit"),
    "rate": ("#command", "video", ".player-bar", "#likert", "#likert label:last-child", "#submit"),
    "subtasks": ("video", ".player-bar", ".subtask .what", "#add", "#timeline", "#submit"),
    "moments": ("video", ".player-bar", "#kinds li:last-child button", "#submit"),
    "mark": ("video", ".player-bar", "#success", "#quality", "#reasons", ".marks .row", "#submit"),
    "correct": ("#command", "video", ".player-bar", "#verdict", "#submit"),
    "check": ("#command", ".ask h2", ".ask .choices", "video", ".map", ".clause-bar", "#submit"),
    "segment": (".words", "#prompt", ".places", "#submit"),
    "ground": ("#command", ".ask h2", "video", ".map", ".clause-bar", "#submit"),
}
"""What people need of each page."""
THERE = """[...document.querySelectorAll("video:not([preload=none])")].every(one => one.readyState)
    && [...document.images].every(one => one.complete)"""


def test_nothing_that_is_needed_is_below_the_fold(site: Site, context: BrowserContext) -> None:
    assert set(NEEDED) == set(task_names())
    site.sign_in(context)
    page = context.new_page()
    page.set_viewport_size({"width": 1280, "height": 800})
    addresses = [(f"/practice/{task}", task) for task in NEEDED]
    for address, task in (*addresses, *((f"/s/sea/{task}", task) for task in TASKS)):
        page.goto(site.url + address)
        expect(page.locator("#submit")).to_be_enabled()
        becomes(page, partial(page.evaluate, THERE), expected=True)
        drawn_anew(page)
        assert out_of_sight(page, *NEEDED[task]) == [], address
        picture = page.locator("video").first.bounding_box()
        assert task == "segment" or (picture is not None and picture["height"] >= SMALLEST_PICTURE)
