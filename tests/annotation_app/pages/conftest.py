from __future__ import annotations

import logging
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from flask import Flask
from playwright.sync_api import BrowserContext, Page
from sqlalchemy import Engine, delete, select

from annotation_app.core.config import DATABASE_FILE, open_instance
from annotation_app.items.new_items import NewItem, add_item
from annotation_app.serving.factory import create_app
from annotation_app.store.database import opened, transaction
from annotation_app.store.models import Answer, Item, Slot
from annotation_app.studies.study_file import Question, StudyConfig, TaskConfig
from annotation_app.work.handing_out import find_study
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import Browser as Known
from tests.annotation_app.browser import execute, rows_in
from tests.annotation_app.conftest import set_up
from tests.annotation_app.in_browser import serving, sign_in
from tests.annotation_app.pages.films import film
from tests.annotation_app.rendered import VIDEOS

COMMAND = "Go to the red crate."
NOTATION = "EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the red crate)))"
TASKS = ("describe", "segment", "ground", "check", "rate")

STUDY = StudyConfig(
    name="sea",
    title="A study",
    tasks={task: TaskConfig(answers=2, practice=False) for task in TASKS},
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
        return rows_in(self.engine, select(Answer).where(Answer.task == task))

    def add(self, task: str, text: str, **more: object) -> None:
        add_about(self.engine, self.study, task, text, **more)

    def only(self, task: str, text: str, **more: object) -> None:
        """Make this the one item of a task that is there."""
        about = select(Item.id).filter_by(task=task)
        execute(self.engine, delete(Slot).where(Slot.item_id.in_(about)))
        self.add(task, text, **more)

    def open(self, context: BrowserContext, task: str) -> Page:
        """A page of a new person who has agreed."""
        return self.visit(context, f"/s/{self.study.name}/{task}")

    def visit(self, context: BrowserContext, path: str) -> Page:
        """Some page as it is for a new person who has agreed."""
        self.sign_in(context)
        page = context.new_page()
        page.goto(self.url + path)
        return page

    def sign_in(self, context: BrowserContext) -> None:
        """Make a context's pages those of a new person who has agreed."""
        sign_in(context, Known(self.app, study=self.study.name), self.url)


def add_about(
    engine: Engine, study: StudyConfig, task: str, text: str = COMMAND, **more: object
) -> None:
    """Add an item about a command for the first video."""
    about = {"text": text, "command": 1, "video": VIDEOS[0], **more}
    with transaction(engine) as session:
        found = find_study(session, study.name)
        add_item(session, found, study, NewItem(task, text, about))


@pytest.fixture(scope="session")
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return film(tmp_path_factory.mktemp("films"))


@contextmanager
def served(study: StudyConfig, database: Path) -> Iterator[Site]:
    """An app that serves a database with a study at some port."""
    config = replace(open_instance(database.parent), rate_limits=False)
    with quiet_werkzeug(), opened(database) as engine:
        app = create_app(config, engine)
        with serving(app) as address:
            yield Site(address, app, engine, study)


@contextmanager
def quiet_werkzeug() -> Iterator[None]:
    logger = logging.getLogger("werkzeug")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


@pytest.fixture(scope="session")
def filled(films: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database with one item for each task but describe, which has all videos."""
    database = tmp_path_factory.mktemp("filled") / DATABASE_FILE
    set_up(database, STUDY, films)
    sdcs = to_json(parse_brackets(NOTATION, command=COMMAND))
    shown = {
        "2": {"video": VIDEOS[1], "objects": [], "places": []},
        "3": {"video": VIDEOS[0], "objects": ["boxes-1"], "places": []},
    }
    with opened(database) as engine:
        add_about(engine, STUDY, "segment")
        add_about(engine, STUDY, "ground", sdcs=sdcs)
        add_about(engine, STUDY, "check", sdcs=sdcs, shown=shown)
        add_about(engine, STUDY, "rate", own_video=VIDEOS[0], right=None)
    return database


@pytest.fixture
def site(tmp_path: Path, filled: Path) -> Iterator[Site]:
    """That database, served."""
    database = open_instance(tmp_path / "instance").instance / DATABASE_FILE
    shutil.copyfile(filled, database)
    with served(STUDY, database) as found:
        yield found
