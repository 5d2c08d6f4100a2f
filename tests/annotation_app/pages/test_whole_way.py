"""From a video to a corpus, with the keyboard alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect
from sqlalchemy import select, update

from annotation_app.core.config import DATABASE_FILE, open_instance
from annotation_app.store.database import opened, transaction
from annotation_app.store.models import Item, Slot
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from g3.sdc.sdc_notation import to_json
from tests.annotation_app.conftest import PATIENCE_MS, set_up
from tests.annotation_app.pages.conftest import COMMAND, TASKS, served
from tests.annotation_app.pages.segmenting import TREE, make_tree_by_keys
from tests.annotation_app.pages.test_tasks import send_by_keys, tab_to
from tests.annotation_app.rendered import VIDEOS

pytestmark = pytest.mark.slow

STUDY = StudyConfig(
    name="whole",
    title="A study",
    only=VIDEOS[:2],
    tasks={task: TaskConfig(practice=task == "rate") for task in TASKS},
)


def enter(page: Page, url: str) -> None:
    """Begin the study and go to its page, as somebody who is new does."""
    page.goto(f"{url}/s/whole")
    tab_to(page, "input[name=agree]")
    page.keyboard.press("Space")
    with page.expect_navigation():
        page.keyboard.press("Enter")
    expect(page.get_by_role("heading", level=1)).to_have_text("Your tasks")


def choose(page: Page, task: str) -> None:
    """Go to a task, from wherever one is."""
    tab_to(page, ".brand")
    with page.expect_navigation():
        page.keyboard.press("Enter")
    tab_to(page, f'a.button[href*="/{task}"]')
    with page.expect_navigation():
        page.keyboard.press("Enter")


def watch(page: Page) -> None:
    tab_to(page, "video")
    page.keyboard.press("Space")
    expect(page.get_by_text("You have watched it to the end")).to_be_visible()


def play(page: Page) -> None:
    tab_to(page, ".play")
    page.keyboard.press("Space")
    expect(page.get_by_text("You have watched it to the end")).to_be_visible()


def annotate(page: Page) -> None:
    """All tasks but rate."""
    choose(page, "describe")
    watch(page)
    tab_to(page, "#text")
    page.keyboard.type(COMMAND)
    send_by_keys(page)
    choose(page, "segment")
    make_tree_by_keys(page)
    send_by_keys(page)
    choose(page, "ground")
    tab_to(page, '[data-key="play"]')
    page.keyboard.press("Space")
    expect(page.get_by_text("You have watched it to the end")).to_be_visible()
    page.keyboard.press("2")
    send_by_keys(page)
    choose(page, "check")
    for _ in range(page.locator(".clause-bar button").count()):
        if page.get_by_text("Watch the video to its end before").is_visible():
            play(page)
        page.keyboard.press("n")
        page.keyboard.press("]")
    send_by_keys(page)


def rate(page: Page) -> None:
    """Practise, then rate the command with both videos."""
    choose(page, "rate")
    expect(page.get_by_role("heading", level=1)).to_have_text("Practice: Rate")
    watch(page)
    page.keyboard.press("5")
    page.keyboard.press("Control+Enter")
    expect(page.locator("#feedback a")).to_be_visible()
    tab_to(page, "#feedback a")
    with page.expect_navigation():
        page.keyboard.press("Enter")
    for key in ("5", "1"):
        watch(page)
        page.keyboard.press(key)
        send_by_keys(page)
    expect(page.get_by_role("heading", level=1)).to_contain_text("Thank you")


def test_from_a_video_to_a_corpus(
    chromium: Browser, context: BrowserContext, tmp_path: Path, films: Path
) -> None:
    database = open_instance(tmp_path / "instance").instance / DATABASE_FILE
    set_up(database, STUDY, films)
    with opened(database) as engine, transaction(engine) as session:
        for table in (Item, Slot):  # the first video, whose second thing can be seen, comes first
            session.execute(update(table).values(rank=2.0))
        first_item = select(Item.id).where(Item.video == VIDEOS[0])
        session.execute(update(Slot).where(Slot.item_id.in_(first_item)).values(rank=1.0))
        session.execute(update(Item).where(Item.video == VIDEOS[0]).values(rank=1.0))
    with served(STUDY, database) as site:
        first = context.new_page()
        enter(first, site.url)
        annotate(first)
        other = chromium.new_context()
        other.set_default_timeout(PATIENCE_MS)
        second = other.new_page()
        enter(second, site.url)
        rate(second)
        other.close()
    out = tmp_path / "corpus"
    assert run(["annotate", "export", str(out), "--instance", str(tmp_path / "instance")]) == 0
    corpus = Corpus.load(out)
    (command,) = corpus.commands.values()
    assert command.text == COMMAND
    right, random = sorted(corpus.annotations, key=lambda a: a.source)
    assert (right.source, random.source) == ("positive", "random")
    assert to_json(right.sdcs) == TREE
    assert [thing.id for thing in right.groundings[-1]] == ["boxes-1"]
    assert sorted(judgment.rating for judgment in corpus.judgments) == ["SA", "SD"]
