"""A study of one's own videos and words in a real browser."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, expect

from annotation_app.cli import served_studies
from annotation_app.core.config import open_instance
from annotation_app.serving import server
from annotation_app.serving.factory import create_app
from annotation_app.store.database import opened
from tests.annotation_app.browser import Browser as Known
from tests.annotation_app.conftest import put_tables
from tests.annotation_app.in_browser import SERIOUS, errors_of, look, serving, sign_in
from tests.annotation_app.study_setup.clips import clip

ITEMS = [
    {
        "video": "push",
        "command": "Push the cup.",
        "right": [4, 5],
        "good": "It does.",
        "again": "No.",
    },
    {"video": "lift", "command": "Wait.", "right": [1, 2], "good": "It lifts.", "again": "Look!"},
]
STUDY = {
    "name": "arm",
    "title": "Commands for an arm",
    "videos": "clips",
    "commands": "commands.csv",
    "robot": "robot arm",
    "statement": "The {robot} does what the command asks.",
    "scale": ["Not at all", "Hardly", "Partly", "Mostly", "Wholly"],
    "tasks": {
        "describe": {"instructions": "1. Watch.\n2. Type in **your own words**.\n   - one"},
        "rate": {
            "title": "Judge",
            "practice_items": ITEMS,
            "instructions": "Read [this](https://example.org).\n\n> Then judge.\n\n```\ncode\n```",
        },
    },
}  # fmt: skip


@pytest.mark.slow
def test_people_practise_and_rate_with_the_studys_words(
    context: BrowserContext, tmp_path: Path
) -> None:
    clip(tmp_path / "clips/push.mp4", 40)
    clip(tmp_path / "clips/lift.webm", 140)
    (tmp_path / "commands.csv").write_text("video,command\npush,Push the cup.\n")
    (tmp_path / "arm.yaml").write_text(json.dumps(STUDY))
    config = replace(open_instance(tmp_path / "instance"), rate_limits=False)
    put_tables(config.database)
    server.prepare(config)
    served_studies.put_file(config, tmp_path / "arm.yaml")
    with opened(config.database) as engine:
        app = create_app(config, engine)
        with serving(app) as url:
            sign_in(context, Known(app, study="arm"), url)
            page = context.new_page()
            errors = errors_of(page)
            page.goto(f"{url}/practice/rate?study=arm")
            expect(page.locator("legend")).to_have_text(
                "“The robot arm does what the command asks.”"
            )
            for right, told in (("Wholly", "It does."), ("Not at all", "It lifts.")):
                page.locator("video").evaluate("video => video.play()")
                expect(page.get_by_text("You have watched it to the end.")).to_be_visible()
                page.get_by_label("Partly").check()
                page.get_by_role("button", name="Check my answer").click()
                expect(page.locator("#feedback")).to_contain_text("Not quite.")
                page.get_by_label(right).check()
                page.get_by_role("button", name="Check my answer").click()
                expect(page.locator("#feedback")).to_contain_text(told)
                page.get_by_role("link", name="Go on").click()
            expect(page.locator("h1")).to_have_text("Judge")
            expect(page.locator("#command")).to_have_text("Push the cup.")
            for task in ("rate", "describe"):
                for scheme in ("light", "dark"):
                    page.emulate_media(color_scheme=scheme)
                    page.goto(f"{url}/s/arm/{task}")
                    assert look(page, f"own-{task}-{scheme}", SERIOUS) == []
            assert errors == []
