from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from flask import Flask
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright
from sqlalchemy import Engine, select

from annotation_app.config import open_instance
from annotation_app.database import open_database, transaction
from annotation_app.factory import create_app
from annotation_app.models import Answer
from annotation_app.pipeline import NewItem, add_item
from annotation_app.schema import migrate
from annotation_app.setup import put_study, rendered_videos
from annotation_app.study import Question, StudyConfig, TaskConfig
from annotation_app.work import find_study
from g3.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import Browser as Known
from tests.annotation_app.in_browser import CHROMIUM, FLAGS, serving
from tests.annotation_app.pages.films import film
from tests.annotation_app.rendered import VIDEOS

PATIENCE_MS = 30_000
COMMAND = "Go to the red crate."
NOTATION = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the red crate)))"
TASKS = ("describe", "segment", "ground", "check", "rate")

STUDY = StudyConfig(
    name="sea",
    title="A study",
    tasks={task: TaskConfig(answers=2) for task in TASKS},
    questions=(Question("english", "Is English your first language?", ("Yes", "No")),),
    qualification=("I am at least 18 years old.",),
)


@dataclass(frozen=True)
class Site:
    """A running app with a study."""

    url: str
    app: Flask
    engine: Engine
    study: StudyConfig = STUDY

    def answers(self, task: str) -> list[Answer]:
        with transaction(self.engine) as session:
            return list(session.scalars(select(Answer).where(Answer.task == task)))

    def add(self, task: str, text: str = COMMAND, **more: object) -> None:
        about = {"text": text, "command": 1, "video": VIDEOS[0], **more}
        with transaction(self.engine) as session:
            add_item(
                session,
                find_study(session, self.study.name),
                self.study,
                NewItem(task, text, about),
            )

    def open(self, context: BrowserContext, task: str) -> Page:
        """A page of a new person who has agreed."""
        self.sign_in(context)
        page = context.new_page()
        page.goto(f"{self.url}/s/{self.study.name}/{task}")
        return page

    def sign_in(self, context: BrowserContext) -> None:
        """Make a context's pages those of a new person who has agreed."""
        cookie = Known(self.app, study=self.study.name).client.get_cookie("session")
        assert cookie is not None
        context.add_cookies([{"name": "session", "value": cookie.value, "url": self.url}])


@pytest.fixture(scope="session")
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return film(tmp_path_factory.mktemp("films"))


@pytest.fixture(scope="module")  # while Playwright runs, asyncio can't be used by other tests
def chromium() -> Iterator[Browser]:
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed")
    expect.set_options(timeout=PATIENCE_MS)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def context(chromium: Browser) -> Iterator[BrowserContext]:
    made = chromium.new_context(viewport={"width": 1280, "height": 900})
    made.set_default_timeout(PATIENCE_MS)
    yield made
    made.close()


@contextmanager
def served(study: StudyConfig, instance: Path, films: Path) -> Iterator[Site]:
    """An app that serves a study at some port."""
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    config = replace(open_instance(instance), rate_limits=False)
    engine = open_database(config.database)
    migrate(engine)
    with transaction(engine) as session:
        put_study(session, study, rendered_videos(films))
    app = create_app(config, engine)
    with serving(app) as address:
        yield Site(address, app, engine, study)
    engine.dispose()


@pytest.fixture
def site(tmp_path: Path, films: Path) -> Iterator[Site]:
    """A study with one item for each task but describe, which has all videos."""
    with served(STUDY, tmp_path / "instance", films) as found:
        sdcs = to_json(parse_brackets(NOTATION, command=COMMAND))
        found.add("segment")
        found.add("ground", sdcs=sdcs)
        shown = {
            "2": {"video": VIDEOS[1], "objects": [], "places": []},
            "3": {"video": VIDEOS[0], "objects": ["boxes-1"], "places": []},
        }
        found.add("check", sdcs=sdcs, shown=shown)
        found.add("rate", own_video=VIDEOS[0], right=None)
        yield found
